"""How a nest of loops is cut into blocks: how many iterations each has, and which elements of each
array it needs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.errors import ArgumentError
from vividc.machine.parallel import Parallel
from vividc.program import WORD_BYTES, Program
from vividc.sim.footprint.boxes import (
    Block,
    Box,
    Boxes,
    inside_bounds,
    meet,
    touched_boxes,
)
from vividc.sim.footprint.footprint import loop_bounds

Array = NDArray[np.generic]
_PARTS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64, 96, 128)
"""Into how many blocks the loops directly inside are cut."""
_FEW = 2
"""So many blocks a tile are too few for transfers to go on while tiles compute."""
_PLACES = (2, 1)
"""How many blocks may have their windows in a scratchpad at once."""

MOST_BLOCKS = 20_000
"""Of a nest: more are not planned, as a launch of so many small ones has more steps than it may."""


@dataclass(frozen=True, slots=True)
class Window:
    """Elements of an array that a block needs, a box of them, and what it stores of them.

    `is_moved_in`: they are not all written anew.
    """

    box: Box
    stores: Box | None
    is_moved_in: bool

    @property
    def row(self) -> int:
        """Words from a row to the next."""
        return self.box[-1][1] - self.box[-1][0]

    @property
    def words(self) -> int:
        """Words in a scratchpad."""
        return math.prod([end - start for start, end in self.box])

    def offset(self, box: Box) -> tuple[int, int]:
        """First byte and end, from the window's, of a box in it."""
        corners = []
        for at in ([start for start, _ in box], [end - 1 for _, end in box]):
            index = 0
            for (start, end), position in zip(self.box, at, strict=True):
                index = index * (end - start) + position - start
            corners.append(index)
        return WORD_BYTES * corners[0], WORD_BYTES * (corners[1] + 1)


Windows = ReadOnly[str, Window]


@dataclass(frozen=True)
class BlockPlan:
    """Blocks in the order of iterations, with the windows of each; `resident`: windows that all
    blocks only read, and that are the same; `places`: of so many blocks of a tile the windows are
    in its scratchpad at once, so that those of one move while the other runs.
    """

    blocks: tuple[Block, ...]
    windows: tuple[Windows, ...]
    resident: Windows
    places: int = 1

    def place(self, slack: int) -> int:
        """Bytes of a block's windows, with `slack` bytes more for each array."""
        return max((size + count * slack for size, count in self._sizes), default=0)

    @cached_property
    def _sizes(self) -> frozenset[tuple[int, int]]:
        """Bytes and number of the windows of blocks."""
        return frozenset((_bytes_of(one, 0), len(one)) for one in self.windows)

    def need(self, slack: int) -> int:
        """Bytes of a scratchpad, with `slack` bytes more for each array."""
        return _bytes_of(self.resident, slack) + self.places * self.place(slack)


def _bytes_of(windows: Windows, slack: int) -> int:
    return sum(WORD_BYTES * window.words + slack for window in windows.values())


@dataclass(frozen=True)
class NestLaunch:
    """What is to be cut: a nest with the words of a launch and the counters around it.

    `tables`: first byte and end of each constant table in a scratchpad, whose last bytes they are.
    """

    program: Program
    parallel: Parallel
    inputs: ReadOnly[str, int]
    arrays: ReadOnly[str, Array]
    flat: frozenset[str]
    machine: Accelerator
    tables: ReadOnly[str, tuple[int, int]]

    @property
    def slack(self) -> int:
        """Bytes that a place has more than its array, so that this can start in any bank."""
        return WORD_BYTES * (self.program.fabric.scratchpad.banks - 1)

    @property
    def room(self) -> int:
        """Bytes of a scratchpad before its tables."""
        size = self.program.fabric.scratchpad.size_bytes
        return min((start for start, _ in self.tables.values()), default=size)

    @property
    def bounds(self) -> tuple[int, int]:
        """First iteration, and the one after the last."""
        return loop_bounds(self.parallel, self.inputs)

    def windows(self, block: Block) -> dict[str, Window]:
        """What a block needs."""
        shapes = {name: array.shape for name, array in self.arrays.items()}
        widths = {name: array.itemsize for name, array in self.arrays.items()}
        touched = touched_boxes(self.parallel, self.inputs, shapes, widths, block, self.flat)
        return {
            name: self._window(name, boxes)
            for name, boxes in touched.items()
            if boxes.hull is not None
        }

    def _window(self, name: str, boxes: Boxes) -> Window:
        hull = boxes.hull
        assert hull is not None
        if boxes.stores is None and len(hull) > 1:
            hull = (*hull[:-1], self._widened(hull[-1], self.arrays[name].shape[-1], name))
        return Window(hull, boxes.stores, not boxes.filled)

    def _widened(self, columns: tuple[int, int], length: int, name: str) -> tuple[int, int]:
        """Columns up to the ends of DRAM's granules, which are moved whole, and so that rows are as
        far apart as the program wishes.
        """
        start, end = columns
        granule = self.machine.dram.granule_bytes // WORD_BYTES
        if length % granule == 0:
            start, end = start // granule * granule, -(-end // granule) * granule
        wish = self.program.pitches.get(name)
        if wish is not None:
            apart = (wish - (end - start)) % self.program.fabric.scratchpad.banks
            end += apart
            if end > length and start >= apart:  # the last columns have some before them
                start, end = start - apart, end - apart
        return (start, end) if end <= length else columns

    def moved(self, windows: Windows) -> int:
        """About the cycles of DRAM's channel that a block's transfers take."""
        total = 0
        for name, window in windows.items():
            if window.is_moved_in:
                total += self._channel(name, window.box)
            if window.stores is not None:
                total += self._channel(name, window.stores)
        return total

    def _channel(self, name: str, box: Box) -> int:
        whole = len(box) == 1 or box[-1] == (0, self.arrays[name].shape[-1])
        rows = 1 if whole else math.prod([b - a for a, b in box[:-1]])
        size = WORD_BYTES * math.prod([b - a for a, b in box]) // max(rows, 1)
        start = 0 if whole else WORD_BYTES * box[-1][0]
        return rows * self.machine.dram.cycles(start, start + size)


@dataclass(frozen=True, order=True, slots=True)
class Choice:
    """A way to cut a nest.

    Attributes
    ----------
    channel
        About the cycles of DRAM's channel, and what tiles wait for the first and the last blocks.
    length
        Iterations of a block.
    parts
        Into how many parts the loops inside are cut.
    places
        Of blocks, in each scratchpad.
    moved
        Of `channel`, what is not waiting.
    """

    channel: float
    length: int
    parts: int
    places: int
    moved: float = 0.0


def block_choices(launch: NestLaunch) -> list[Choice]:
    """Ways to cut a nest that should fit, what moves least first; none where nothing fits, or no
    iteration is left.
    """
    first, last = launch.bounds
    if first >= last:
        return []
    inside = inside_bounds(launch.parallel, launch.inputs, first, last)
    width = inside[1] - inside[0] if launch.parallel.blocked else 1
    counts = [n for n in _PARTS if n == 1 or (launch.parallel.blocked and width >= 2 * n)]
    return sorted(
        choice
        for places in _PLACES
        for parts in counts
        for choice in _choices(launch, (first, last), inside, parts, places)
    )


def middle_block(launch: NestLaunch, choice: Choice) -> tuple[int, Block]:
    """How many blocks there are, and one of the middle."""
    first, last = launch.bounds
    cuts = _cut((first, last), choice.length)
    inside = inside_bounds(launch.parallel, launch.inputs, first, last)
    parts = _insides(launch, inside, choice.parts)
    return len(cuts) * len(parts), Block(*cuts[len(cuts) // 2], parts[len(parts) // 2])


def plan_of(launch: NestLaunch, choice: Choice) -> BlockPlan | None:
    """The plan of a choice, with shorter blocks where the longest need more than those that were
    looked at; None: it does not fit, or blocks may not run in another order.
    """
    first, last = launch.bounds
    rows, inside = (first, last), inside_bounds(launch.parallel, launch.inputs, first, last)
    if choice.parts * -(-(last - first) // choice.length) > MOST_BLOCKS:
        return None
    plan = _plan(launch, rows, inside, choice)
    while plan.need(launch.slack) > launch.room and choice.length > 1:
        choice = replace(choice, length=max(1, 3 * choice.length // 4))
        plan = _plan(launch, rows, inside, choice)
    fits = plan.need(launch.slack) <= launch.room
    return plan if fits and (choice.parts == 1 or _may_be_blocked(plan)) else None


def _choices(
    launch: NestLaunch, rows: tuple[int, int], inside: tuple[int, int], parts: int, places: int
) -> Iterator[Choice]:
    """What fits."""
    count = rows[1] - rows[0]
    tiles = len(launch.machine.tiles)
    low, high = 0, count
    while low < high:
        middle = (low + high + 1) // 2
        if _probe(launch, rows, inside, middle, parts).need(places) <= launch.room:
            low = middle
        else:
            high = middle - 1
    for number in (1, 2, 3, 4, 6, 8):
        length = -(-low // number)
        if not length:
            continue
        length = -(-count // -(-count // length))
        blocks = parts * -(-count // length)
        probed = _probe(launch, rows, inside, length, parts)
        moved = probed.moved * count / length * parts + probed.once
        waits = 1 + tiles / (2 * blocks) + _FEW * tiles / (blocks * blocks)
        yield Choice(moved * waits, length, parts, places, moved)


def _cut(rows: tuple[int, int], length: int) -> list[tuple[int, int]]:
    return [(a, min(a + length, rows[1])) for a in range(rows[0], rows[1], length)]


def _insides(launch: NestLaunch, inside: tuple[int, int], parts: int) -> list[tuple[int, int]]:
    """The loops inside in parts that are as long as whole granules of DRAM."""
    if parts == 1:
        return [inside]
    granule = launch.machine.dram.granule_bytes // WORD_BYTES
    length = -(-(inside[1] - inside[0]) // parts)
    return _cut(inside, -(-length // granule) * granule)


@dataclass(frozen=True, slots=True)
class _Probe:
    """The largest of a few blocks.

    Attributes
    ----------
    resident, own
        Bytes that a scratchpad needs for what all read alike, and for the rest.
    once, moved
        Cycles of DRAM's channel for these.
    """

    resident: int
    own: int
    once: int
    moved: int

    def need(self, places: int) -> int:
        """Bytes of a scratchpad with so many places."""
        return self.resident + places * self.own


def _probe(
    launch: NestLaunch, rows: tuple[int, int], inside: tuple[int, int], length: int, parts: int
) -> _Probe:
    """Of a block of the middle, the first, and the last."""
    cuts, halves = _cut(rows, length), _insides(launch, inside, parts)
    places = {(0, 0), (len(cuts) // 2, len(halves) // 2), (len(cuts) - 1, 0), (0, len(halves) - 1)}
    found = [launch.windows(Block(*cuts[at[0]], halves[at[1]])) for at in sorted(places)]
    resident = _common(found) if len(found) > 1 else {}
    own = [{n: w for n, w in one.items() if n not in resident} for one in found]
    return _Probe(
        _bytes_of(resident, launch.slack),
        max(_bytes_of(one, launch.slack) for one in own),
        launch.moved(resident),
        max(launch.moved(one) for one in own),
    )


def _common(windows: Sequence[Windows]) -> dict[str, Window]:
    """Those that are alike and only read."""
    return {
        name: window
        for name, window in windows[0].items()
        if window.stores is None and all(one.get(name) == window for one in windows)
    }


def _plan(
    launch: NestLaunch, rows: tuple[int, int], inside: tuple[int, int], choice: Choice
) -> BlockPlan:
    halves = _insides(launch, inside, choice.parts)
    blocks = [Block(*cut, part) for cut in _cut(rows, choice.length) for part in halves]
    windows = [launch.windows(block) for block in blocks]
    resident = _common(windows)
    own = tuple({n: w for n, w in one.items() if n not in resident} for one in windows)
    return BlockPlan(tuple(blocks), own, resident, choice.places)


def _may_be_blocked(plan: BlockPlan) -> bool:
    """Whether no block of the same outer iterations writes what another one touches: then their
    order does not matter, which is another one than the kernel's.
    """
    same: dict[int, list[Windows]] = {}
    for block, windows in zip(plan.blocks, plan.windows, strict=True):
        same.setdefault(block.first, []).append(windows)
    return not any(
        _clash(one, other)
        for group in same.values()
        for number, one in enumerate(group)
        for other in group[number + 1 :]
    )


def _clash(one: Windows, other: Windows) -> bool:
    for name in one.keys() & other.keys():
        for a, b in ((one[name], other[name]), (other[name], one[name])):
            if a.stores is not None and meet(a.stores, b.box):
                return True
    return False


def refusal(launch: NestLaunch) -> ArgumentError:
    """What to tell of a nest of which no block fits a scratchpad."""
    first, last = launch.bounds
    inside = inside_bounds(launch.parallel, launch.inputs, first, last)
    plan = _plan(launch, (first, first + 1), inside, Choice(0.0, 1, 1, 1))
    windows: dict[str, int] = {}
    for one in (*plan.windows, plan.resident):
        for name, window in one.items():
            windows[name] = max(windows.get(name, 0), WORD_BYTES * window.words)
    parts = ", ".join(
        f"{name} {size} of {launch.arrays[name].nbytes}" for name, size in windows.items()
    )
    return ArgumentError(
        f"one iteration of the loop needs {plan.need(launch.slack)} bytes of a scratchpad of "
        f"{launch.room}: {parts}",
        loc=launch.parallel.loc,
        hint="let an iteration do less, or go through the arrays by blocks that fit",
    )
