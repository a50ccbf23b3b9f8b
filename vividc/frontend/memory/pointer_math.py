"""Comparisons and differences of pointers into one array, as C makes them: `p != end`, `p - x`.

Both become arithmetic on byte offsets from the start of the array.
"""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import KernelError
from vividc.ssa.edit import substitute
from vividc.ssa.ir import Function, Instr, Int, Key, Named, Phi, Value

_CASTS = frozenset({"zext", "sext", "trunc", "freeze"})
_TO_INTEGER = frozenset({"ptrtoint", "ptrtoaddr"})
_ANY_HINT = "compare indices, or pass a length instead of an end pointer"
ANY = "vividc.below"
"""Flag of comparisons that are false for pointers to different arrays."""


def without_freezes(function: Function) -> Function:
    """No pointer of a kernel is undefined: drop `freeze` of pointers."""
    frozen = {
        op.id: op.operands[0]
        for block in function.blocks
        for op in block.instrs
        if op.op == "freeze" and op.type == "ptr"
    }
    return substitute(function, frozen)


def compare_pointers(
    op: Instr, root: Callable[[Value], str], offset: Callable[[Value], Value]
) -> Instr:
    """`icmp` of two pointers as one of their byte offsets.

    Parameters
    ----------
    root
        Array of a pointer, "" if unknown.
    offset
        Byte offset of a pointer in its array.

    Raises
    ------
    KernelError
        The pointers may be of different arrays.
    """
    left, right = op.operands
    if Int(0) in op.operands:  # no array is at NULL
        return _decided(
            op, op.pred in ("ne", "ugt", "uge") if right == Int(0) else op.pred[0] != "e"
        )
    if not root(left) or root(left) != root(right):
        if ANY in op.flags:
            return _decided(op, False)
        reason = "a comparison of pointers to different arrays"
        raise KernelError(reason, loc=op.loc, hint=_ANY_HINT)
    # Below its array's start, where C leaves a pointer undefined, its offset is negative.
    pred = op.pred if op.pred in ("eq", "ne") else "s" + op.pred[1:]
    return Instr(op.id, "icmp", "i32", (offset(left), offset(right)), pred=pred, loc=op.loc)


def _decided(op: Instr, truth: bool) -> Instr:
    return Instr(op.id, "or", "i1", (Int(int(truth)), Int(0)), loc=op.loc)


def differences(function: Function, root: Callable[[Value], str]) -> dict[int, Value]:
    """Addresses as integers that only meet addresses in the same array, in subtractions and
    comparisons: the pointer of each.
    """
    pointers = {
        op.id: op.operands[0]
        for block in function.blocks
        for op in block.instrs
        if op.op in _TO_INTEGER
    }
    origin = _origins(function, pointers)
    allowed: set[int | None] = set(pointers)
    for block in function.blocks:
        for item in block.items:
            meeting = _roots_met(item, origin, pointers, root)
            if meeting is not None:
                allowed -= meeting
        leave = block.branch
        for operand in (leave.cond, leave.value):
            if isinstance(operand, Named):
                allowed.discard(origin.get(operand.key))
    return {name: pointer for name, pointer in pointers.items() if name in allowed}


def _origins(function: Function, pointers: dict[int, Value]) -> dict[Key, int]:
    """The address that each conversion of one was made from, by result."""
    origin: dict[Key, int] = {id_: id_ for id_ in pointers}
    for block in function.blocks:
        for op in block.instrs:
            source = op.operands[0] if op.op in _CASTS and op.operands else None
            if isinstance(source, Named) and source.key in origin:
                origin[op.id] = origin[source.key]
    return origin


def _roots_met(
    item: Instr | Phi,
    origin: dict[Key, int],
    pointers: dict[int, Value],
    root: Callable[[Value], str],
) -> set[int | None] | None:
    """Addresses that the instruction uses otherwise than against one of the same array."""
    operands = (
        item.operands if isinstance(item, Instr) else tuple(value for _, value in item.incoming)
    )
    used = [origin.get(x.key) if isinstance(x, Named) else None for x in operands]
    if used == [None] * len(used) or (isinstance(item, Instr) and item.op in _CASTS):
        return None
    roots = {"" if id_ is None else root(pointers[id_]) for id_ in used}
    if (
        isinstance(item, Instr)
        and item.op in ("sub", "icmp")
        and len(roots) == 1
        and "" not in roots
    ):
        return None
    return set(used)
