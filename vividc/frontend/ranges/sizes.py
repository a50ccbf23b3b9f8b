"""Bounds of products of one array's dimensions: the array fits the memory."""

from __future__ import annotations

from vividc.frontend.llvm.ir import Local, Op, Operand, WideFunction
from vividc.frontend.ranges.interval import Interval

_AXIS = ".shape"
_CONVERSIONS = frozenset({"zext", "sext", "freeze"})

Axes = frozenset[str]


def bounds_of_sizes(function: WideFunction, limit: int) -> dict[str, Interval]:
    """Bounds of the products of different dimensions of one array, by name.

    Parameters
    ----------
    limit
        The largest number of elements of an array, also of one with a dimension of 0 left out.
    """
    found: dict[str, Axes] = {}
    for block in function.blocks:
        for op in block.ops:
            axes = _axes(op, found)
            if axes:
                found[op.name] = axes
    return {
        name: (0, limit)
        for name, axes in found.items()
        if len(axes) > 1 and isinstance(function.definitions[name], Op)
    }


def _axes(op: Op, found: dict[str, Axes]) -> Axes:
    """The dimensions whose product `op` computes; none if it computes something else."""
    if op.op in _CONVERSIONS:
        return _of(op.args[0], found)
    if op.op != "mul":
        return frozenset()
    left, right = (_of(arg, found) for arg in op.args)
    arrays = {axis.rsplit(_AXIS, 1)[0] for axis in left | right}
    return left | right if left and right and not left & right and len(arrays) == 1 else frozenset()


def _of(operand: Operand, found: dict[str, Axes]) -> Axes:
    if not isinstance(operand, Local):
        return frozenset()
    if operand.name in found:
        return found[operand.name]
    stem, _, axis = operand.name.rpartition(_AXIS)
    return frozenset({operand.name}) if stem and axis.isdigit() else frozenset()
