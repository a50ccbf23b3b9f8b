"""Comparisons and differences of pointers into one array, as C makes them: `p != end`, `p - x`.

Both become arithmetic on byte offsets from the start of the array.
"""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import KernelError
from vividc.frontend.llvm.ir import Int, Local, Op, Operand, WideFunction, WidePhi, substitute

_CASTS = frozenset({"zext", "sext", "trunc", "freeze"})
_TO_INTEGER = frozenset({"ptrtoint", "ptrtoaddr"})
_ANY_HINT = "compare indices, or pass a length instead of an end pointer"
ANY = "vividc.below"
"""Flag of comparisons that are false for pointers to different arrays."""


def without_freezes(function: WideFunction) -> WideFunction:
    """No pointer of a kernel is undefined: drop `freeze` of pointers."""
    frozen = {
        op.name: op.args[0]
        for block in function.blocks
        for op in block.ops
        if op.op == "freeze" and op.type == "ptr"
    }
    return substitute(function, frozen)


def compare_pointers(
    op: Op, root: Callable[[Operand], str], offset: Callable[[Operand], Operand]
) -> Op:
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
    left, right = op.args
    if Int(0) in op.args:  # no array is at NULL
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
    return Op(op.name, "icmp", "i32", (offset(left), offset(right)), pred, loc=op.loc)


def _decided(op: Op, truth: bool) -> Op:
    return Op(op.name, "or", "i1", (Int(int(truth)), Int(0)), loc=op.loc)


def differences(function: WideFunction, root: Callable[[Operand], str]) -> dict[str, Operand]:
    """Addresses as integers that only meet addresses in the same array, in subtractions and
    comparisons: the pointer of each.
    """
    pointers = {
        op.name: op.args[0] for block in function.blocks for op in block.ops if op.op in _TO_INTEGER
    }
    origin = _origins(function, pointers)
    allowed = set(pointers)
    for block in function.blocks:
        for item in block.items:
            meeting = _roots_met(item, origin, pointers, root)
            if meeting is not None:
                allowed -= meeting
        leave = block.exit
        for operand in (leave.cond, leave.value):
            if isinstance(operand, Local):
                allowed.discard(origin.get(operand.name, ""))
    return {name: pointer for name, pointer in pointers.items() if name in allowed}


def _origins(function: WideFunction, pointers: dict[str, Operand]) -> dict[str, str]:
    """The address that each conversion of one was made from, by result."""
    origin = {name: name for name in pointers}
    for block in function.blocks:
        for op in block.ops:
            source = op.args[0] if op.op in _CASTS and op.args else None
            if isinstance(source, Local) and source.name in origin:
                origin[op.name] = origin[source.name]
    return origin


def _roots_met(
    item: Op | WidePhi,
    origin: dict[str, str],
    pointers: dict[str, Operand],
    root: Callable[[Operand], str],
) -> set[str] | None:
    """Addresses that the instruction uses otherwise than against one of the same array."""
    operands = item.args if isinstance(item, Op) else tuple(value for _, value in item.incoming)
    used = [origin.get(x.name, "") if isinstance(x, Local) else "" for x in operands]
    if not any(used) or (isinstance(item, Op) and item.op in _CASTS):
        return None
    roots = {root(pointers[name]) if name else "" for name in used}
    if isinstance(item, Op) and item.op in ("sub", "icmp") and len(roots) == 1 and "" not in roots:
        return None
    return set(used)
