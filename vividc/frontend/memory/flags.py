"""Loads from bool arrays: a byte that is 0 or 1 is a predicate already.

Numba loads a byte and compares it with 0. Run when memory is resolved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from vividc.machine.params import DType
from vividc.ssa.edit import FreshIds, substitute
from vividc.ssa.ir import Function, Instr, Int, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused

_BYTE = "i8"


def load_flags(function: Function) -> Function:
    """Make predicates of the loads from parameters of bool, whose bytes are 0 or 1."""
    arrays = {param.name for param in function.params if param.ndim and param.dtype is DType.BOOL}
    loads = frozenset(
        op.id
        for block in function.blocks
        for op in block.instrs
        if op.op == "load" and op.array in arrays and op.type == _BYTE
    )
    if not loads:
        return function
    ids = FreshIds(function)
    tests: dict[int, Value] = {
        op.id: _flag(op.operands[0], ids)
        for block in function.blocks
        for op in block.instrs
        if _is_set(op) and _reads(op, loads)
    }
    function = substitute(function, tests)
    blocks = tuple(
        replace(
            block, instrs=tuple(new for op in block.instrs for new in _rewritten(op, loads, ids))
        )
        for block in function.blocks
    )
    return remove_unused(replace(function, blocks=blocks))


def _rewritten(op: Instr, loads: frozenset[int], ids: FreshIds) -> Iterator[Instr]:
    if op.id in loads:
        flag = replace(op, id=ids(op.id), type="i1")
        yield flag
        yield Instr(op.id, "zext", _BYTE, (Ref(flag.id),), source="i1", loc=op.loc)
    elif op.op == "icmp" and op.pred == "eq" and op.operands[1] == Int(0) and _reads(op, loads):
        yield Instr(op.id, "xor", "i1", (_flag(op.operands[0], ids), Int(1)), loc=op.loc)
    else:
        yield op


def _is_set(op: Instr) -> bool:
    """A test whether a byte is not 0, if that is 0 or 1."""
    if op.op == "trunc":
        return op.type == "i1"
    return op.op == "icmp" and op.pred == "ne" and op.operands[1] == Int(0)


def _reads(op: Instr, loads: frozenset[int]) -> bool:
    return isinstance(op.operands[0], Ref) and op.operands[0].id in loads


def _flag(byte: Value, ids: FreshIds) -> Ref:
    assert isinstance(byte, Ref)
    return Ref(ids(byte.id))
