"""Merge equal operations of a block: what narrowing wrote twice, and hoisting brought together."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace

from vividc.dfg.cfg import Block, Branch, Function, Instr, Phi, Ref, Value
from vividc.dfg.opcodes import MEMORY, OPCODES


def merge_equal(function: Function) -> Function:
    """The function in which no block computes the same word twice; the same object if none did.

    Operations of different blocks stay apart: a word that lives from block to block costs more than
    an operation.
    """
    same: dict[int, Value] = {}
    kept = [_kept(block, same) for block in function.blocks]
    if not same:
        return function
    blocks = tuple(
        _renamed(block, instrs, same) for block, instrs in zip(function.blocks, kept, strict=True)
    )
    return replace(function, blocks=blocks)


def _kept(block: Block, same: dict[int, Value]) -> list[Instr]:
    """The block's first instructions of each kind; `same` gets what replaces the others."""
    first: dict[Hashable, Ref] = {}
    kept = []
    for instr in block.instrs:
        operands = _final(instr.operands, same)
        if instr.op in MEMORY:
            kept.append(instr)
            continue
        key = (instr.op, instr.type, _ordered(instr, operands))
        known = first.setdefault(key, Ref(instr.id))
        if known.id == instr.id:
            kept.append(instr)
        else:
            same[instr.id] = known
    return kept


def _ordered(instr: Instr, operands: tuple[Value, ...]) -> tuple[Value, ...]:
    if not OPCODES[instr.op].commutes:
        return operands
    first, second, *rest = operands
    return (*sorted((first, second), key=str), *rest)


def _final(operands: tuple[Value, ...], same: dict[int, Value]) -> tuple[Value, ...]:
    return tuple(same.get(v.id, v) if isinstance(v, Ref) else v for v in operands)


def _renamed(block: Block, instrs: list[Instr], same: dict[int, Value]) -> Block:
    return replace(
        block,
        phis=tuple(_renamed_phi(phi, same) for phi in block.phis),
        instrs=tuple(replace(i, operands=_final(i.operands, same)) for i in instrs),
        branch=_renamed_branch(block.branch, same),
    )


def _renamed_phi(phi: Phi, same: dict[int, Value]) -> Phi:
    incoming = tuple((pred, _final((value,), same)[0]) for pred, value in phi.incoming)
    return replace(phi, incoming=incoming)


def _renamed_branch(branch: Branch, same: dict[int, Value]) -> Branch:
    cond = branch.cond if branch.cond is None else _final((branch.cond,), same)[0]
    value = branch.value if branch.value is None else _final((branch.value,), same)[0]
    return replace(branch, cond=cond, value=value)
