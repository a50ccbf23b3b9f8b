"""Removal of operations that nothing reads, from functions."""

from __future__ import annotations

from dataclasses import replace

from vividc.host import time_limit
from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.edit import uses
from vividc.ssa.ir import Function, Instr, Phi, Ref, Value


def without_dead(function: Function) -> Function:
    """Without operations that nothing reads; accesses to memory and phis stay."""
    while True:
        read = {
            value.id
            for block in function.blocks
            for value in (
                *uses(block),
                *(value for phi in block.phis for _, value in phi.incoming),
            )
            if isinstance(value, Ref)
        }
        blocks = tuple(
            replace(b, instrs=tuple(i for i in b.instrs if i.id in read or i.op in MEMORY))
            for b in function.blocks
        )
        if blocks == function.blocks:
            return function
        function = replace(function, blocks=blocks)


def remove_dead(function: Function) -> Function:
    """Without phis and instructions whose results reach no store, branch, call or return."""
    time_limit.step("it was lowered")
    live: set[int] = set()
    pending: list[Value] = []
    for block in function.blocks:
        pending.extend(block.branch.read)
        for instr in block.instrs:
            if has_effect(instr):
                pending.extend(instr.operands)
    while pending:
        value = pending.pop()
        if not isinstance(value, Ref) or value.id in live:
            continue
        live.add(value.id)
        definition = function.definitions.get(value.id)
        if isinstance(definition, Phi):
            pending.extend(value for _, value in definition.incoming)
        elif definition is not None:
            pending.extend(definition.operands)
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.id in live),
            instrs=tuple(i for i in block.instrs if i.id in live or has_effect(i)),
        )
        for block in function.blocks
    )
    return replace(function, blocks=blocks)


def has_effect(instr: Instr) -> bool:
    """Whether an instruction must stay even if nothing reads its result."""
    if instr.op == "call":
        hint = instr.pred.startswith(_HINTS)
        return not hint and not (instr.pred.startswith("llvm.") and instr.type != "void")
    return instr.op in ("store", Opcode.STORE)


_HINTS = tuple(
    f"llvm.{name}"
    for name in ("assume", "dbg.", "lifetime.", "donothing", "prefetch", "experimental.noalias.")
)
"""Functions of LLVM that return nothing and do nothing."""
