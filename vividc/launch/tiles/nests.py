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
from vividc.errors import ArgumentError
from vividc.launch.job import Job
from vividc.launch.tiles.blocks import Array, BlockPlan, NestLaunch, Window
from vividc.launch.tiles.chosen import Chosen, chosen
from vividc.launch.tiles.placed import Placed, table_extents
from vividc.machine.parallel import Run
from vividc.machine.words import WORD_BYTES, WORD_MASK
from vividc.program import Program
from vividc.sim.bind import arguments
from vividc.sim.footprint.boxes import Box, flat_arrays
from vividc.sim.footprint.footprint import values_of

MOST_STEPS = 50_000
"""Of a launch graph: which steps wait for which takes a bit for every two, 160 MB."""


def nests_job(
    program: Program,
    args: Sequence[object],
    kwargs: ReadOnly[str, object],
    fabric: str | os.PathLike[str] | Accelerator,
    runs: Sequence[Run] | None = None,
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
    if runs is None:
        every = range(len(program.nests))
        return _Builder(Job(fabric), program, arrays, inputs, every).build(runs_of(program, inputs))
    used = {number for number, _ in runs}
    return _Builder(Job(fabric), program, arrays, inputs, used).build(runs)


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


def nests_cycles(
    program: Program,
    args: Sequence[object],
    kwargs: ReadOnly[str, object],
    fabric: str | os.PathLike[str] | Accelerator,
) -> int:
    """Cycles that `nests_job` is predicted to take: those of each nest, one after the other.

    Raises
    ------
    ArgumentError
        As `nests_job`.
    """
    arrays, inputs = arguments(program, args, kwargs)
    builder = _Builder(Job(fabric), program, arrays, inputs, range(len(program.nests)))
    return builder.predicted(runs_of(program, inputs))


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
class _Pad:
    """Which steps use which bytes of a scratchpad, as far as later ones may have to wait for them:
    bytes that are taken again are forgotten, as whoever takes them waits for those before.
    """

    uses: list[tuple[int, int, tuple[int, ...]]] = field(default_factory=list)
    turn: int = 0
    """Of the places of blocks, by which block is next."""

    def before(self, start: int, end: int) -> set[int]:
        """What a step that writes these bytes must wait for."""
        return {n for a, b, steps in self.uses if a < end and start < b for n in steps}

    def take(self, start: int, end: int, steps: tuple[int, ...]) -> None:
        """Bytes that these steps use, which have waited for those before."""
        self.uses = [use for use in self.uses if not (start <= use[0] and use[1] <= end)]
        self.uses.append((start, end, steps))


class _Builder:
    def __init__(
        self,
        job: Job,
        program: Program,
        arrays: ReadOnly[str, Array],
        inputs: ReadOnly[str, int],
        used: Iterable[int],
    ) -> None:
        self._job = job
        self._program = program
        self._arrays = arrays
        self._inputs = inputs
        self._flat = self._flat_arrays(used)
        self._tables = table_extents(program, inputs)
        self._traffic = {
            name: _Traffic(1 if name in self._flat else array.ndim)
            for name, array in arrays.items()
        }
        self._pads: dict[int, _Pad] = defaultdict(_Pad)
        self._plans: dict[tuple[int, tuple[int, ...]], Chosen] = {}
        self._next = 0

    def _flat_arrays(self, used: Iterable[int]) -> frozenset[str]:
        """Arrays that are one axis of words in one of these nests, and so in all of the graph."""
        shapes = {name: array.shape for name, array in self._arrays.items()}
        flat = {name for name, array in self._arrays.items() if array.itemsize != WORD_BYTES}
        for nest in (self._program.nests[number] for number in used):
            assert nest.parallel is not None
            flat |= flat_arrays(nest.parallel, shapes, nest.pitches)
        return frozenset(flat)

    def build(self, runs: Iterable[Run]) -> Job:
        for number, counters in runs:
            self._nest(number, _words(counters))
        return self._job

    def predicted(self, runs: Iterable[Run]) -> int:
        """Cycles of all these nests: while one runs, the next one's program and blocks come, and
        tiles that are done with one begin the next.
        """
        total, ends, uneven, held = 0, 0, 0, -1
        for number, counters in runs:
            _, one = self._chosen(number, _words(counters))
            configuring = one.configuring if number != held else 0
            computing = one.computing
            if not total:  # the first one's program hides behind its first blocks' way only
                computing += configuring
            cycles = max(one.channel, computing, configuring)
            total += cycles
            ends = max(ends, one.channel + one.ends - cycles)
            uneven, held = one.uneven, number
        return total + max(ends, uneven)

    def _chosen(self, number: int, counters: ReadOnly[str, int]) -> tuple[NestLaunch, Chosen]:
        """A run of a nest, and how it is cut; one that depends on no counter, once."""
        nest = self._program.nests[number]
        parallel = nest.parallel
        assert parallel is not None
        inputs = {**self._inputs, **counters}
        machine = self._job.accelerator
        launch = NestLaunch(nest, parallel, inputs, self._arrays, self._flat, machine, self._tables)
        used = {term.key for term in parallel.terms}
        key = (number, tuple(counters[name] for name in sorted(counters) if name in used))
        if key not in self._plans:
            self._plans[key] = chosen(launch)
        return launch, self._plans[key]

    def _nest(self, number: int, counters: ReadOnly[str, int]) -> None:
        launch, expected = self._chosen(number, counters)
        plan = expected.plan
        self._demand_room(launch, len(plan.blocks))
        tiles = self._dealt(len(plan.blocks))
        resident = self._resident(launch, plan, tiles)
        for place, tile in enumerate(tiles):
            self._block(launch, plan, place, tile, resident)

    def _demand_room(self, launch: NestLaunch, blocks: int) -> None:
        """A graph is made before it is checked and run: it has an end.

        Raises
        ------
        ArgumentError
            The steps so far and those of a run of a nest are more than `MOST_STEPS`.
        """
        steps = self._job.count + blocks * (1 + len(self._arrays))
        if steps > MOST_STEPS:
            raise ArgumentError(
                f"a launch of {self._program.name} takes more than {MOST_STEPS:,} transfers and "
                "runs of blocks",
                loc=launch.parallel.loc,
                hint="launch fewer iterations of the loops around at once",
            )

    def _dealt(self, count: int) -> list[int]:
        tiles = len(self._job.accelerator.tiles)
        dealt = [(self._next + number) % tiles for number in range(count)]
        self._next = (self._next + count) % tiles
        return dealt

    def _resident(self, launch: NestLaunch, plan: BlockPlan, tiles: list[int]) -> Placed:
        """What all blocks read, moved once to all tiles."""
        placed, used = Placed(launch, 0), sorted(set(tiles))
        if not used:
            return placed
        self._hold(used, launch.program)
        for name, window in plan.resident.items():
            placed.add(name, window)
            start = placed.starts[name]
            view = self._view(name, window.box)
            after = set(self._traffic[name].before(window.box, False))
            after = after.union(*(self._pads[tile].before(start, placed.end) for tile in used))
            step = self._job.move_in(used, view, start, after=sorted(after))
            self._traffic[name].add(window.box, step, False)
            placed.moves.append(step)
        for tile in used if placed.end else ():
            self._pads[tile].take(0, placed.end, tuple(placed.moves))
        return placed

    def _hold(self, tiles: list[int], program: Program) -> None:
        """Tiles that are configured one by one begin as soon as each is."""
        for tile in tiles:
            if not self._job.holds([tile], program):
                self._job.configure(tile, program)

    def _block(
        self, launch: NestLaunch, plan: BlockPlan, number: int, tile: int, resident: Placed
    ) -> None:
        placed, pad = resident.copy(), self._pads[tile]
        windows = plan.windows[number]
        start = resident.end + pad.turn % plan.places * plan.place(launch.slack)
        placed.end = start
        for name, window in windows.items():
            placed.add(name, window)
        before = pad.before(start, placed.end)
        for name, window in windows.items():
            if window.is_moved_in:
                after = {*before, *self._traffic[name].before(window.box, False)}
                view = self._view(name, window.box)
                step = self._job.move_in(tile, view, placed.starts[name], after=sorted(after))
                self._traffic[name].add(window.box, step, False)
                placed.moves.append(step)
        inputs = placed.inputs(plan.blocks[number])
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
        pad.take(start, placed.end, (run, *out))
        if resident.end:
            pad.take(0, resident.end, (run,))
        pad.turn += 1

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


def _words(counters: ReadOnly[str, int]) -> dict[str, int]:
    """Counters as launch words."""
    return {key: value & WORD_MASK for key, value in counters.items()}
