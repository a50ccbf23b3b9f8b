"""A kernel that is a sequence of nests, over all tiles: a launch graph of blocks of each nest.

Blocks are ordered by what they touch: one that reads what an earlier one writes, writes what it
reads, or writes the same waits for it, so that the result is that of the loops in their order;
others run at the same time. An overlap, as of rows of a stencil, is moved to both.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.launch.job import Job
from vividc.launch.tiles.blocks import Array, BlockPlan, NestLaunch, Window, plan_blocks
from vividc.machine.parallel import Run
from vividc.machine.words import WORD_BYTES, WORD_MASK
from vividc.program import Program, pitch_words
from vividc.sim.bind import arguments
from vividc.sim.footprint.boxes import Box, flat_arrays
from vividc.sim.footprint.footprint import values_of


def nests_job(
    program: Program,
    args: Sequence[object],
    kwargs: ReadOnly[str, object],
    fabric: str | os.PathLike[str] | Accelerator,
    runs: Iterable[Run] | None = None,
) -> Job:
    """The launch graph of a program's nests on these arguments.

    Parameters
    ----------
    runs
        Which of the nests, in which order (see `runs_of`); None: all.

    Raises
    ------
    ArgumentError
        The arguments do not fit the kernel, or an iteration of a nest no scratchpad.
    """
    arrays, inputs = arguments(program, args, kwargs)
    builder = _Builder(Job(fabric), program, arrays, inputs)
    return builder.build(runs_of(program, inputs) if runs is None else runs)


def runs_of(program: Program, inputs: ReadOnly[str, int]) -> Iterator[Run]:
    """The nests in the order of their runs, each with the counters around it, of a launch with
    these words.
    """
    order = program.order
    assert order is not None

    def bound(term: int, counters: ReadOnly[str, int]) -> int:
        value = values_of(order.terms, {**inputs, **counters})[term]
        return 0 if value is None else value

    return order.runs(bound)


@dataclass
class _Traffic:
    """Which steps read and write which elements of an array, as far as later ones may have to wait
    for them: what is written again is forgotten, as whoever touches it waits for that.
    """

    axes: int
    boxes: NDArray[np.int64] = field(init=False)
    steps: NDArray[np.int64] = field(init=False)
    writes: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        self.boxes = np.empty((0, self.axes, 2), np.int64)
        self.steps = np.empty(0, np.int64)
        self.writes = np.empty(0, np.bool_)

    def before(self, box: Box, is_write: bool) -> list[int]:
        """What a step that touches a box must wait for."""
        at = np.array(box)
        found = ((self.boxes[:, :, 0] < at[:, 1]) & (self.boxes[:, :, 1] > at[:, 0])).all(axis=1)
        if not is_write:
            found &= self.writes
        return [int(step) for step in self.steps[found]]

    def add(self, box: Box, step: int, is_write: bool) -> None:
        """A step that has waited for these."""
        at = np.array(box)
        if is_write:
            inside = (self.boxes[:, :, 0] >= at[:, 0]) & (self.boxes[:, :, 1] <= at[:, 1])
            kept = ~inside.all(axis=1)
            self.boxes, self.steps = self.boxes[kept], self.steps[kept]
            self.writes = self.writes[kept]
        self.boxes = np.concatenate([self.boxes, at[None]])
        self.steps = np.append(self.steps, step)
        self.writes = np.append(self.writes, is_write)


@dataclass
class _Tile:
    """What the next block of a tile waits for: the last run, and what it moved out."""

    last: tuple[int, ...] = ()


class _Builder:
    def __init__(
        self,
        job: Job,
        program: Program,
        arrays: ReadOnly[str, Array],
        inputs: ReadOnly[str, int],
    ) -> None:
        self._job = job
        self._program = program
        self._arrays = arrays
        self._inputs = inputs
        self._flat = self._flat_arrays()
        self._traffic = {
            name: _Traffic(1 if name in self._flat else array.ndim)
            for name, array in arrays.items()
        }
        self._tiles: dict[int, _Tile] = defaultdict(_Tile)
        self._plans: dict[tuple[int, tuple[int, ...]], BlockPlan] = {}
        self._next = 0

    def _flat_arrays(self) -> frozenset[str]:
        """Arrays that are one axis of words in some nest, and so in all."""
        shapes = {name: array.shape for name, array in self._arrays.items()}
        flat = {name for name, array in self._arrays.items() if array.itemsize != WORD_BYTES}
        for nest in self._program.nests:
            assert nest.parallel is not None
            flat |= flat_arrays(nest.parallel, shapes, nest.pitches)
        return frozenset(flat)

    def build(self, runs: Iterable[Run]) -> Job:
        for number, counters in runs:
            self._nest(number, {key: value & WORD_MASK for key, value in counters.items()})
        return self._job

    def _nest(self, number: int, counters: ReadOnly[str, int]) -> None:
        nest = self._program.nests[number]
        parallel = nest.parallel
        assert parallel is not None
        inputs = {**self._inputs, **counters}
        launch = NestLaunch(nest, parallel, inputs, self._arrays, self._flat, self._job.accelerator)
        used = {term.key for term in parallel.terms}
        key = (number, tuple(counters[name] for name in sorted(counters) if name in used))
        if key not in self._plans:
            self._plans[key] = plan_blocks(launch)
        plan = self._plans[key]
        tiles = self._dealt(len(plan.blocks))
        resident = self._resident(launch, plan, tiles)
        for number_, tile in enumerate(tiles):
            self._block(launch, plan, number_, tile, resident)

    def _dealt(self, count: int) -> list[int]:
        tiles = len(self._job.accelerator.tiles)
        dealt = [(self._next + number) % tiles for number in range(count)]
        self._next = (self._next + count) % tiles
        return dealt

    def _resident(self, launch: NestLaunch, plan: BlockPlan, tiles: list[int]) -> _Placed:
        """What all blocks read, moved once to all tiles."""
        placed, used = _Placed(launch, 0), sorted(set(tiles))
        if not used:
            return placed
        self._hold(used, launch.program)
        before = tuple(step for tile in used for step in self._tiles[tile].last)
        for name, window in plan.resident.items():
            placed.add(name, window)
            start = placed.starts[name]
            view = self._view(name, window.box)
            after = {*before, *self._traffic[name].before(window.box, False)}
            step = self._job.move_in(used, view, start, after=sorted(after))
            self._traffic[name].add(window.box, step, False)
            placed.moves.append(step)
        return placed

    def _hold(self, tiles: list[int], program: Program) -> None:
        if not self._job.holds(tiles, program):
            self._job.configure(tiles, program)

    def _block(
        self, launch: NestLaunch, plan: BlockPlan, number: int, tile: int, resident: _Placed
    ) -> None:
        placed = resident.copy()
        before = self._tiles[tile].last
        windows = plan.windows[number]
        for name, window in windows.items():
            placed.add(name, window)
            if window.is_moved_in:
                after = {*before, *self._traffic[name].before(window.box, False)}
                view = self._view(name, window.box)
                step = self._job.move_in(tile, view, placed.starts[name], after=sorted(after))
                self._traffic[name].add(window.box, step, False)
                placed.moves.append(step)
        inputs = {**launch.inputs, **plan.blocks[number].words(launch.parallel), **placed.words()}
        stores = {
            name: placed.within(name, window.stores)
            for name, window in windows.items()
            if window.stores is not None
        }
        extents = placed.extents()
        run = self._job.execute(
            tile, launch.program, inputs, extents, stores, after=sorted({*placed.moves, *before})
        )
        out = [
            step
            for name, window in windows.items()
            if window.stores is not None
            for step in self._moved_out(tile, name, window, placed.starts[name], run)
        ]
        self._tiles[tile].last = (run, *out)

    def _moved_out(self, tile: int, name: str, window: Window, start: int, run: int) -> list[int]:
        """Steps that move what was stored: row by row, if the rows have more in the scratchpad."""
        box = window.stores
        assert box is not None
        after = sorted({run, *self._traffic[name].before(box, True)})
        whole = box[1:] == window.box[1:]
        rows = [box] if whole else [((n, n + 1), *box[1:]) for n in range(*box[0])]
        steps = [
            self._job.move_out(
                tile, start + window.offset(row)[0], self._view(name, row), after=after
            )
            for row in rows
        ]
        for row, step in zip(rows, steps, strict=True):
            self._traffic[name].add(row, step, True)
        return steps

    def _view(self, name: str, box: Box) -> Array:
        """Elements of a box; of an array as one axis, the words that it has."""
        array = self._arrays[name]
        if name not in self._flat:
            return array[tuple(slice(*ends) for ends in box)]
        flat = array.reshape(-1)
        ((start, end),) = box
        each = flat.itemsize
        return flat[WORD_BYTES * start // each : -(-WORD_BYTES * end // each)]


@dataclass
class _Placed:
    """Windows in a scratchpad, one behind the other from a byte on, and what moves them in."""

    launch: NestLaunch
    end: int
    windows: dict[str, Window] = field(default_factory=dict)
    starts: dict[str, int] = field(default_factory=dict)
    moves: list[int] = field(default_factory=list)

    def copy(self) -> _Placed:
        """The same, to add to."""
        return _Placed(
            self.launch, self.end, dict(self.windows), dict(self.starts), list(self.moves)
        )

    def add(self, name: str, window: Window) -> None:
        """Place a window so that elements are in the banks that the program wished for."""
        banks = self.launch.program.fabric.scratchpad.banks
        wish = self.launch.program.banks.get(name, 0) + self._first(name, window)
        place = self.end // WORD_BYTES
        self.starts[name] = WORD_BYTES * (place + (wish - place) % banks)
        self.windows[name] = window
        self.end = self.starts[name] + WORD_BYTES * window.words

    def _first(self, name: str, window: Window) -> int:
        """Words from an array's first element, were it there, to a window's."""
        if len(window.box) == 1:
            return window.box[0][0]
        (row, _), (column, _) = window.box
        return row * window.row + column

    def within(self, name: str, box: Box) -> tuple[int, int]:
        """First byte and end of a box in its window."""
        first, end = self.windows[name].offset(box)
        return self.starts[name] + first, self.starts[name] + end

    def extents(self) -> dict[str, tuple[int, int]]:
        """First byte and end of each array; of those that are not touched, nothing."""
        found = dict.fromkeys(self.launch.arrays, (0, 0))
        for name, window in self.windows.items():
            start = self.starts[name]
            found[name] = (start, start + WORD_BYTES * window.words)
        return found

    def words(self) -> dict[str, int]:
        """Launch words: addresses and pitches."""
        found = {f"&{name}": 0 for name in self.launch.arrays}
        pitches = dict.fromkeys(self.launch.program.pitches, 0)
        for name, window in self.windows.items():
            first = WORD_BYTES * self._first(name, window)
            found[f"&{name}"] = (self.starts[name] - first) & WORD_MASK
            if name in pitches:
                flat = name in self.launch.flat
                pitches[name] = self.launch.arrays[name].shape[-1] if flat else window.row
        return found | pitch_words(pitches)
