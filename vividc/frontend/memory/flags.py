"""Loads from bool arrays: a byte that is 0 or 1 is a predicate already.

Numba loads a byte and compares it with 0. Run when memory is resolved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from vividc.frontend.llvm.ir import Int, Local, Op, Operand, WideFunction, remove_dead, substitute

_BYTE = "i8"
_FLAG = ".flag"


def load_flags(function: WideFunction, arrays: frozenset[str]) -> WideFunction:
    """Make predicates of the loads from `arrays`, whose bytes are 0 or 1."""
    loads = frozenset(
        op.name
        for block in function.blocks
        for op in block.ops
        if op.op == "load" and op.array in arrays and op.type == _BYTE
    )
    if not loads:
        return function
    tests: dict[str, Operand] = {
        op.name: _flag(op.args[0])
        for block in function.blocks
        for op in block.ops
        if _is_set(op) and _reads(op, loads)
    }
    function = substitute(function, tests)
    blocks = tuple(
        replace(block, ops=tuple(new for op in block.ops for new in _rewritten(op, loads)))
        for block in function.blocks
    )
    return remove_dead(replace(function, blocks=blocks))


def _rewritten(op: Op, loads: frozenset[str]) -> Iterator[Op]:
    if op.name in loads:
        flag = replace(op, name=op.name + _FLAG, type="i1")
        yield flag
        yield Op(op.name, "zext", _BYTE, (Local(flag.name),), source="i1", loc=op.loc)
    elif op.op == "icmp" and op.pred == "eq" and op.args[1] == Int(0) and _reads(op, loads):
        yield Op(op.name, "xor", "i1", (_flag(op.args[0]), Int(1)), loc=op.loc)
    else:
        yield op


def _is_set(op: Op) -> bool:
    """A test whether a byte is not 0, if that is 0 or 1."""
    if op.op == "trunc":
        return op.type == "i1"
    return op.op == "icmp" and op.pred == "ne" and op.args[1] == Int(0)


def _reads(op: Op, loads: frozenset[str]) -> bool:
    return isinstance(op.args[0], Local) and op.args[0].name in loads


def _flag(byte: Operand) -> Local:
    assert isinstance(byte, Local)
    return Local(byte.name + _FLAG)
