"""Which elements of its arrays a block of a nest touches: intervals of subscripts, axis by axis."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from vividc.machine.parallel import BLOCK_FIRST, BLOCK_LAST, FIRST, LAST, Access, Parallel
from vividc.machine.words import WORD_BYTES, WORD_MASK
from vividc.sim.footprint.coverage import fills
from vividc.sim.footprint.footprint import (
    ANYTHING,
    Interval,
    bytes_of,
    chunk_intervals,
)

Box = tuple[Interval, ...]
"""First index and end of each axis; never empty."""


@dataclass(frozen=True, slots=True)
class Block:
    """Iterations `first` to before `last`, and `inside`: those of the loops directly inside."""

    first: int
    last: int
    inside: Interval

    def words(self, parallel: Parallel) -> dict[str, int]:
        """Its launch words."""
        words = {FIRST: self.first & WORD_MASK, LAST: self.last & WORD_MASK}
        if parallel.blocked:
            words[BLOCK_FIRST], words[BLOCK_LAST] = (end & WORD_MASK for end in self.inside)
        return words


@dataclass(frozen=True, slots=True)
class Boxes:
    """What a block touches of an array; None: nothing.

    `filled`: every element of `stores` is written, and none is read before.
    """

    loads: Box | None = None
    stores: Box | None = None
    filled: bool = False

    @property
    def hull(self) -> Box | None:
        """Both together."""
        return union(self.loads, self.stores)


def union(one: Box | None, other: Box | None) -> Box | None:
    """The least box around two."""
    if one is None or other is None:
        return other if one is None else one
    return tuple((min(a, c), max(b, d)) for (a, b), (c, d) in zip(one, other, strict=True))


def meet(one: Box, other: Box) -> bool:
    """Whether two boxes have an element in common."""
    return all(a < d and c < b for (a, b), (c, d) in zip(one, other, strict=True))


def inside_bounds(parallel: Parallel, inputs: Mapping[str, int], first: int, last: int) -> Interval:
    """First value and end of the counters of the loops directly inside these iterations."""
    known = chunk_intervals(parallel, inputs, first, last)
    ends = [(known[a], known[b]) for a, b in parallel.blocked]
    found = [(a[0], b[1]) for a, b in ends if a is not None and b is not None]
    if not found:
        return ANYTHING
    low, high = min(a for a, _ in found), max(b for _, b in found)
    return low, max(low, high)


def touched_boxes(
    parallel: Parallel,
    inputs: Mapping[str, int],
    shapes: Mapping[str, tuple[int, ...]],
    widths: Mapping[str, int],
    block: Block,
    flat: Collection[str],
) -> dict[str, Boxes]:
    """What a block touches of each array.

    Parameters
    ----------
    inputs
        The launch words of parameters, shapes and counters around.
    shapes, widths
        Of each array, and bytes of its elements.
    flat
        Arrays that are taken as one axis of words of 32 bits: not all is known of their subscripts.
    """
    words = {**inputs, **block.words(parallel)}
    known = chunk_intervals(parallel, words, block.first, block.last)
    found = dict.fromkeys(shapes, Boxes())
    filled: dict[str, Box] = {}
    for access in parallel.accesses:
        name = access.array
        box = (
            _flat(access, known[access.term], shapes[name], widths[name])
            if name in flat
            else _box([known[term] for term in access.subscripts], shapes[name])
        )
        if box is None:
            continue
        old = found[name]
        if access.is_store:
            found[name] = Boxes(old.loads, union(old.stores, box))
            if name not in flat and fills(parallel, known, access, block.first, block.last):
                filled[name] = box
        else:
            found[name] = Boxes(union(old.loads, box), old.stores)
    return {
        name: Boxes(one.loads, one.stores, one.loads is None and one.stores == filled.get(name))
        for name, one in found.items()
    }


def flat_arrays(
    parallel: Parallel, shapes: Mapping[str, tuple[int, ...]], pitched: Collection[str]
) -> frozenset[str]:
    """Arrays that have no rows that a launch could lay apart, or elements with unknown
    subscripts.
    """
    unknown = {access.array for access in parallel.accesses if not access.subscripts}
    return frozenset(
        name
        for name, shape in shapes.items()
        if name in unknown or (len(shape) > 1 and name not in pitched)
    )


def _flat(access: Access, index: Interval | None, shape: Sequence[int], width: int) -> Box | None:
    size = width
    for count in shape:
        size *= count
    part = bytes_of(access, index, size)
    if part is None:
        return None
    return ((part[0] // WORD_BYTES, -(-part[1] // WORD_BYTES)),)


def _box(subscripts: Sequence[Interval | None], shape: Sequence[int]) -> Box | None:
    """Subscripts within the array: others are undefined."""
    box = []
    for interval, size in zip(subscripts, shape, strict=True):
        if interval is None:
            return None
        low, high = max(interval[0], 0), min(interval[1] + 1, size)
        if low >= high:
            return None
        box.append((low, high))
    return tuple(box)
