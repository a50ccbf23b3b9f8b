"""Removes operations that nothing reads from functions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from vividc.host import time_limit
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Function, Instr, Ref, Value


def remove_unused(function: Function) -> Function:
    """Drops phis and instructions whose results reach no store, branch, call or return.

    Blocks taken out of a function may read what the others compute.
    """
    time_limit.step("dead code was removed")
    operands: dict[int, Iterable[Value]] = {}
    work: list[Value] = []
    kept: set[int] = set()
    for block in function.blocks:
        operands |= {phi.id: [value for _, value in phi.incoming] for phi in block.phis}
        for instr in block.instrs:
            operands[instr.id] = instr.operands
            if has_effect(instr):
                kept.add(instr.id)
                work += instr.operands
        work += block.branch.read
    while work:
        value = work.pop()
        if isinstance(value, Ref) and value.id not in kept:
            kept.add(value.id)
            work += operands.get(value.id, ())
    if kept >= operands.keys():
        return function
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.id in kept),
            instrs=tuple(instr for instr in block.instrs if instr.id in kept),
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
