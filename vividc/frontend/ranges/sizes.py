"""Bounds of products of one array's dimensions, and of those that the size of an array is of which
the kernel makes: the array fits the memory.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from vividc.frontend.ranges.interval import Interval, full
from vividc.machine.params import Formula
from vividc.ssa.ir import (
    Function,
    Input,
    Instr,
    Int,
    Key,
    Named,
    Value,
    is_dimension,
    without_pitch,
)

_AXIS = ".shape"
_SIGNS: Final = ("s:", "u:")
_SHIFTS: Final = 32
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


Product = tuple[tuple[str, ...], int]
"""Inputs that are multiplied, in order, and a constant."""


def bounds_of_made(function: Function, limit: int) -> dict[Key, Interval]:
    """Upper bounds of products of all that the words of an array of the kernel's are a product of,
    by id: a launch refuses arrays of more than `limit` words. A product of 64 bits that does not
    fit them is undefined.
    """
    sizes = [param.made for param in function.params if param.made]
    sizes += [local.size for local in function.locals if local.size]
    made: dict[tuple[str, ...], int] = {}
    for inputs, factor in filter(None, map(_product_of, sizes)):
        made[inputs] = max(made.get(inputs, 0), factor)
    found: dict[Key, Product] = {}
    bounds: dict[Key, Interval] = {}
    for block in function.blocks if made else ():
        for op in block.instrs:
            product = _multiplied(op, found)
            if product is None:
                continue
            inputs, factor = found[op.id] = product
            if op.type == "i64" and inputs in made and factor > 0:
                bounds[op.id] = (full("i64")[0], limit // made[inputs] * factor)
    return bounds


def _product_of(formula: Formula) -> Product | None:
    """The product that a formula is; None: it is none of inputs and a positive constant."""
    inputs = sorted(item[2:] for item in formula if isinstance(item, str) and item[:2] in _SIGNS)
    factors = [item for item in formula if isinstance(item, int)]
    others = {item for item in formula if isinstance(item, str) and item[:2] not in _SIGNS}
    if not inputs or others - {"*"} or any(factor <= 0 for factor in factors):
        return None
    return tuple(inputs), math.prod(factors)


def _multiplied(op: Instr, found: dict[Key, Product]) -> Product | None:
    """The product of inputs that `op` computes in 64 bits."""
    if op.op in ("sext", "freeze") or (op.op == "zext" and "nneg" in op.flags):
        return next(_factors(op.operands[:1], found), None)
    if op.op == "shl" and isinstance(op.operands[1], Int) and 0 <= op.operands[1].value < _SHIFTS:
        one = next(_factors(op.operands[:1], found), None)
        return None if one is None else (one[0], one[1] << op.operands[1].value)
    if op.op != "mul" or op.type != "i64":
        return None
    parts = [*_factors(op.operands, found)]
    if len(parts) < len(op.operands):
        return None
    inputs = sorted(name for names, _ in parts for name in names)
    return tuple(inputs), math.prod(factor for _, factor in parts)


def _factors(operands: Sequence[Value], found: dict[Key, Product]) -> Iterator[Product]:
    for operand in operands:
        if isinstance(operand, Int):
            yield (), operand.value
        elif isinstance(operand, Named) and operand.key in found:
            yield found[operand.key]
        elif isinstance(operand, Input):
            key = without_pitch(operand).key if is_dimension(operand) else operand.key
            yield (key,), 1


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
