"""Ranges of a function's values, from what is known of its parameters and tables."""

from __future__ import annotations

from vividc.frontend.ranges.interval import Interval, intersect
from vividc.frontend.ranges.ranges import Ranges
from vividc.frontend.ranges.sizes import bounds_of_made, bounds_of_sizes
from vividc.host.once import once_within
from vividc.machine.params import MAX_ELEMENTS
from vividc.machine.words import WORD_BYTES, signed
from vividc.ssa.ir import Function, Key, pitch_of


@once_within
def ranges_of(function: Function) -> Ranges:
    """The ranges of a function without unreachable blocks, found once for it."""
    bounds = _of_shapes(function) | _of_tables(function) | bounds_of_sizes(function, MAX_ELEMENTS)
    for key, interval in bounds_of_made(function, MAX_ELEMENTS).items():
        bounds[key] = intersect(bounds.get(key, interval), interval)
    return Ranges(function, bounds)


def _of_shapes(function: Function) -> dict[Key, Interval]:
    """An array must fit in the scratchpad (checked at launch)."""
    return {
        key: (param.known[axis], param.known[axis]) if param.known else (0, param.limit(axis))
        for param in function.params
        for axis in range(param.ndim)
        for key in (f"{param.name}.shape{axis}", pitch_of(param.name, axis).key)
    }


def _of_tables(function: Function) -> dict[Key, Interval]:
    """Values that the integers read from constant tables can have, by id of the load."""
    contents = {local.name: local.contents for local in function.locals}
    bounds: dict[Key, Interval] = {}
    for block in function.blocks:
        for op in block.instrs:
            words = contents.get(op.array) if op.op == "load" and op.type == "i32" else None
            if words and op.width == WORD_BYTES:
                values = [signed(word) for word in words]
                bounds[op.id] = (min(values), max(values))
    return bounds
