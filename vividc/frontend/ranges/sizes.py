"""Bounds of products of one array's dimensions: the array fits the memory."""

from __future__ import annotations

from vividc.frontend.ranges.interval import Interval
from vividc.ssa.ir import Function, Input, Instr, Key, Named, Value, is_dimension, without_pitch

_AXIS = ".shape"
_CONVERSIONS = frozenset({"zext", "sext", "freeze"})

Axes = frozenset[str]


def bounds_of_sizes(function: Function, limit: int) -> dict[Key, Interval]:
    """Bounds of the products of different dimensions of one array, by id.

    Parameters
    ----------
    limit
        The largest number of elements of an array, also of one with a dimension of 0 left out.
    """
    found: dict[Key, Axes] = {}
    for block in function.blocks:
        for op in block.instrs:
            axes = _axes(op, found)
            if axes:
                found[op.id] = axes
    return {id_: (0, limit) for id_, axes in found.items() if len(axes) > 1}


def _axes(op: Instr, found: dict[Key, Axes]) -> Axes:
    """The dimensions whose product `op` computes; none if it computes something else."""
    if op.op in _CONVERSIONS:
        return _of(op.operands[0], found)
    if op.op != "mul":
        return frozenset()
    left, right = (_of(arg, found) for arg in op.operands)
    arrays = {axis.rsplit(_AXIS, 1)[0] for axis in left | right}
    return left | right if left and right and not left & right and len(arrays) == 1 else frozenset()


def _of(operand: Value, found: dict[Key, Axes]) -> Axes:
    if not isinstance(operand, Named):
        return frozenset()
    if operand.key in found:
        return found[operand.key]
    if not isinstance(operand, Input) or not is_dimension(operand):
        return frozenset()
    return frozenset({without_pitch(operand).key})
