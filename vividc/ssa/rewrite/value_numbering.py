"""Merge equal operations of a block: what narrowing wrote twice, and hoisting brought together."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace

from vividc.machine.opcodes import MEMORY, OPCODES
from vividc.ssa.edit import substitute
from vividc.ssa.ir import Block, Function, Instr, Ref, Value


def merge_equal(function: Function) -> Function:
    """The function in which no block computes the same word twice; the same object if none did.

    Operations of different blocks stay apart: a word that lives from block to block costs more than
    an operation.
    """
    same: dict[int, Value] = {}
    kept = tuple(replace(block, instrs=_kept(block, same)) for block in function.blocks)
    return substitute(replace(function, blocks=kept), same) if same else function


def _kept(block: Block, same: dict[int, Value]) -> tuple[Instr, ...]:
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
    return tuple(kept)


def _ordered(instr: Instr, operands: tuple[Value, ...]) -> tuple[Value, ...]:
    if not OPCODES[instr.opcode].commutes:
        return operands
    first, second, *rest = operands
    return (*sorted((first, second), key=str), *rest)


def _final(operands: tuple[Value, ...], same: dict[int, Value]) -> tuple[Value, ...]:
    return tuple(same.get(v.id, v) if isinstance(v, Ref) else v for v in operands)
