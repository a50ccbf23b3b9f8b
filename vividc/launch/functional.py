"""Computes a job in waves of steps: each wave depends on earlier ones only, and its tiles run in
parallel.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.errors import ArgumentError, InternalError
from vividc.launch.memory import Buffers, Working
from vividc.launch.steps import Array, Execute, Pieces, Step, Transfer
from vividc.program import WORD_BYTES, Program
from vividc.sim.engine import Launch, Run
from vividc.sim.tile import REFERENCE, Tile, shared_tile

Memory = NDArray[np.uint32]
_NO_MEMORY: Final[Memory] = np.zeros(0, np.uint32)
"""Of a run that has been taken over: those of all runs of a job would be many."""


@dataclass
class Outcome:
    """What the timing and the caller need of a job that was carried out.

    Attributes
    ----------
    runs
        What each run of a tile gave, by step.
    chosen
        Places of the rows that each gather, scatter and counted move out moved, by step.
    listed
        How many indices each gather or scatter read in a scratchpad, by step.
    """

    runs: dict[int, Run] = field(default_factory=dict)
    chosen: dict[int, Pieces] = field(default_factory=dict)
    listed: dict[int, int] = field(default_factory=dict)


def carry_out(
    accelerator: Accelerator,
    steps: Sequence[Step],
    waits: Sequence[tuple[int, ...]],
    buffers: Buffers,
    engine: str,
    cycle_limit: int,
    threads: int | None,
) -> Outcome:
    """Carry the steps out and write the arrays that are moved out, if all succeed.

    Raises
    ------
    SimulationError, ArgumentError
        From a run, for an index outside the array of its gather or scatter, or for a count of more
        rows than an array has; no array is changed.
    """
    leaving = (s.view for s in steps if isinstance(s, Transfer) and s.to_dram)
    targets = list({id(view): view for view in leaving}.values())
    working = Working(buffers, {buffers.number(v) for v in targets})
    state = _State(accelerator, buffers, working, engine)
    state.prepare(steps)
    with _working(threads or os.cpu_count() or 1) as run_all:
        for wave in _waves(waits):
            runs = []
            for number in wave:
                step = steps[number]
                if isinstance(step, Transfer):
                    state.transfer(number, step)
                elif isinstance(step, Execute):
                    runs.append(number)
            launches = [state.launch(steps[n], cycle_limit) for n in runs]
            tiles = [state.tile(steps[n]) for n in runs]
            for number, run in zip(runs, run_all(tiles, launches), strict=True):
                state.finish(number, steps[number], run)
    state.working.commit(targets)
    return state.outcome


@contextmanager
def _working(threads: int) -> Iterator[Callable[[Sequence[Tile], Sequence[Launch]], list[Run]]]:
    """A function that runs each of some tiles in so many threads, its caller's among them."""
    if threads == 1:
        yield lambda tiles, launches: list(map(Tile.run, tiles, launches))
        return

    def run_all(tiles: Sequence[Tile], launches: Sequence[Launch]) -> list[Run]:
        done: dict[int, Run] = {}
        failed: dict[int, Exception] = {}
        left = iter(range(len(tiles)))

        def run_some() -> None:
            for number in left:
                try:
                    done[number] = tiles[number].run(launches[number])
                except Exception as error:
                    failed[number] = error

        others = [pool.submit(run_some) for _ in range(min(threads, len(tiles)) - 1)]
        run_some()
        for other in others:
            other.result()
        if failed:
            raise failed[min(failed)]
        return [done[number] for number in range(len(tiles))]

    with ThreadPoolExecutor(threads - 1) as pool:
        yield run_all


def _waves(waits: Sequence[tuple[int, ...]]) -> list[list[int]]:
    depth: list[int] = []
    waves: dict[int, list[int]] = defaultdict(list)
    for number, before in enumerate(waits):
        depth.append(1 + max((depth[n] for n in before), default=-1))
        waves[depth[-1]].append(number)
    return [waves[level] for level in sorted(waves)]


class _State:
    """Scratchpads, DRAM and tiles while a job is carried out."""

    def __init__(
        self, accelerator: Accelerator, buffers: Buffers, working: Working, engine: str
    ) -> None:
        self.working = working
        self._engine = engine
        self.outcome = Outcome()
        self._buffers = buffers
        self._granule = accelerator.dram.granule_bytes
        self._pads = [np.zeros(unit.scratchpad.words, np.uint32) for unit in accelerator.units]
        self._sharing = accelerator.sharing
        self._used: set[int] = set()
        self._tiles: dict[int, Tile] = {}

    def prepare(self, steps: Sequence[Step]) -> None:
        """Each program is decoded once: for all corners, but for the reference engine, which runs
        the words of each tile.
        """
        for step in steps:
            if isinstance(step, Execute):
                program = self._decoded(step)
                if id(program) not in self._tiles:
                    self._tiles[id(program)] = shared_tile(program, self._engine)

    def _decoded(self, step: Execute) -> Program:
        return step.program if self._engine == REFERENCE else step.compiled

    def _take(self, unit: int) -> None:
        """Discard what other forms of the same tiles held in their scratchpads."""
        for other in self._sharing[unit] & self._used:
            self._pads[other][:] = 0
            self._used.remove(other)
        self._used.add(unit)

    def transfer(self, number: int, step: Transfer) -> None:
        """Move words; 64-bit elements do not occur."""
        for tile in step.tiles:
            self._take(tile)
        if step.kind == "scatter":
            rows = self._rows(number, step)
            raw = self._leaving(step, len(rows) * step.view[:1].nbytes)
            self.working.write_rows(step.view, rows, raw)
        elif step.kind == "move out":
            target = step.view if step.count_at is None else self._counted(number, step)
            self.working.write(target, self._leaving(step, target.nbytes))
        else:
            self._bring(number, step)

    def _leaving(self, step: Transfer, size: int) -> NDArray[np.uint8]:
        """So many bytes that leave a scratchpad, as elements of the array that they go to."""
        raw = self._at(step.tiles[0], step, size).copy().view(np.uint8)
        return (raw != 0).view(np.uint8) if step.view.dtype == np.bool_ else raw

    def _bring(self, number: int, step: Transfer) -> None:
        view = self.working.read(step.view)
        if step.kind == "gather":
            view = view[self._rows(number, step)]
        raw = np.ascontiguousarray(view).reshape(-1).view(np.uint8)
        if view.dtype == np.bool_:
            raw = (raw != 0).view(np.uint8)
        for tile in step.tiles:
            place = self._at(tile, step, raw.size)
            place[:] = raw.view(place.dtype)

    def _at(self, tile: int, step: Transfer, size: int) -> NDArray[np.generic]:
        """A view of the bytes, or of the words, of a tile that a transfer moves."""
        pad: NDArray[np.generic] = self._pads[tile]
        if step.pitch == WORD_BYTES:
            pad = pad.view(np.uint8)
        return pad[step.places(size)]

    def _counted(self, number: int, step: Transfer) -> Array:
        assert step.count_at is not None
        count = int(self._pads[step.tiles[0]][step.count_at // WORD_BYTES])
        if count > len(step.view):
            raise ArgumentError(
                f"step {number} (move out) is told to move {count} rows of an array of "
                f"{len(step.view)} rows"
            )
        rows = step.view[:count]
        self.outcome.chosen[number] = self._buffers.pieces(rows)
        return rows

    def _rows(self, number: int, step: Transfer) -> NDArray[np.int64]:
        """Those of its array that a gather or scatter moves, in their order."""
        rows = self._indices(number, step).astype(np.int64)
        wrong = np.flatnonzero((rows < 0) | (rows >= len(step.view)))
        if wrong.size:
            raise ArgumentError(
                f"step {number} ({step.kind}) is told row {rows[wrong[0]]} of an array of "
                f"{len(step.view)} rows, by number {wrong[0]} of its list"
            )
        self.outcome.chosen[number] = self._buffers.rows(step.view, rows, self._granule)
        return rows

    def _indices(self, number: int, step: Transfer) -> Array:
        if step.listed is None:
            assert step.indices is not None
            return self.working.read(step.indices)
        first, end = (byte // WORD_BYTES for byte in step.listed.extent)
        count, *_ = words = self._pads[step.tiles[0]][first:end]
        self.outcome.listed[number] = min(int(count), step.listed.most)
        return words[1 : 1 + self.outcome.listed[number]]

    def tile(self, step: Step) -> Tile:
        """The tile that holds the program of a run."""
        assert isinstance(step, Execute)
        return self._tiles[id(self._decoded(step))]

    def launch(self, step: Step, cycle_limit: int) -> Launch:
        """What the engine gets."""
        assert isinstance(step, Execute)
        self._take(step.tile)
        memory = self._pads[step.tile]
        for local in step.program.locals:
            if local.contents:
                local.fill(memory, step.extents[local.name][0])
        return Launch(memory, step.inputs, cycle_limit, step.extents)

    def finish(self, number: int, step: Step, run: Run) -> None:
        """Keep what the run stored, which is where it was said to be, or in arrays of its own."""
        assert isinstance(step, Execute)
        self.outcome.runs[number] = replace(run, memory=_NO_MEMORY)
        pad, after = self._pads[step.tile].view(np.uint8), run.memory.view(np.uint8)
        own = (step.extents[local.name] for local in step.program.locals)
        for start, end in (*step.stores.values(), *own):
            pad[start:end] = after[start:end]
        if not np.array_equal(self._pads[step.tile], run.memory):
            first = int(np.flatnonzero(pad != after)[0])
            raise InternalError(
                f"a run of {step.program.name} wrote byte {first}, which it was not said to write"
            )
