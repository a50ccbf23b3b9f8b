"""A kernel's parallel loop over all tiles: a launch graph made from its arguments."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.errors import ArgumentError, SimulationError
from vividc.launch.job import Job
from vividc.launch.simulate import JobResult
from vividc.launch.tiles.chunks import (
    Chunk,
    Cut,
    Interval,
    Plan,
    aligned,
    own_sizes,
    plan_chunks,
    slack,
)
from vividc.launch.tiles.dealt import Dealt, costs_of, dealt, probed
from vividc.launch.turns import Turns
from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import WIDE_LOW, Reduction
from vividc.machine.semantics import evaluate
from vividc.machine.words import WORD_MASK
from vividc.program import WORD_BYTES, Program, joined
from vividc.sim.bind import arguments, returned
from vividc.sim.engine import Launch
from vividc.sim.footprint.footprint import chunk_inputs, start_words
from vividc.sim.run import CYCLE_LIMIT, returned_value
from vividc.sim.tile import AUTO, shared_tile


@dataclass(frozen=True, slots=True)
class SpreadOptions:
    """How a loop is spread.

    Attributes
    ----------
    chunk
        Iterations of a chunk; None: as suits the scratchpads.
    double_buffer
        Slices move into one half of a scratchpad while the tile works on the other.
    tiles
        Of so many tiles each gets a chunk before any gets its next one. None: if chunks are as long
        as suits, a chunk goes to the tile that is predicted to be done with it first, else to all
        in turn.
    """

    chunk: int | None = None
    double_buffer: bool = True
    tiles: int | None = None


def spread(
    program: Program,
    args: Sequence[object],
    kwargs: ReadOnly[str, object],
    fabric: str | os.PathLike[str] | Accelerator,
    options: SpreadOptions | None = None,
) -> Spread:
    """The launch graph that runs a program over an accelerator's tiles, on these arguments.

    A program without a parallel loop runs on tile 0.

    Raises
    ------
    ArgumentError
        The arguments do not fit the kernel, a chunk does not fit a scratchpad, or iterations of
        different chunks meet in what they write.
    """
    job = Job(fabric)
    options = options or SpreadOptions()
    arrays, inputs = arguments(program, args, kwargs)
    for name, array in arrays.items():
        if array.dtype.kind != "c" and array.itemsize > WORD_BYTES:
            raise ArgumentError(f"array {name} has elements of {array.itemsize} bytes")
    error = error_of(program)
    sizes = {name: array.nbytes for name, array in arrays.items() if name != error}
    sliced = () if program.parallel is None else program.parallel.sliced
    own = own_sizes(program, inputs)
    sizes |= {name: own[name] for name in sliced}
    cut = Cut(program, inputs, sizes, job.accelerator, options.double_buffer)
    plan = plan_chunks(cut, options.chunk)
    return _Builder(job, cut, plan, arrays).build(options)


@dataclass(frozen=True, slots=True)
class Spread:
    """A spread launch: the job, and the run of each chunk in the order of iterations; `errors`:
    the word of each chunk that says which exception it raised, if it may; `predicted`: cycles, if
    they were.
    """

    job: Job
    program: Program
    plan: Plan
    runs: tuple[int, ...]
    inputs: ReadOnly[str, int]
    arrays: ReadOnly[str, NDArray[np.generic]]
    errors: tuple[NDArray[np.generic], ...] = ()
    predicted: int | None = None

    def simulate(
        self, *, engine: str = AUTO, cycle_limit: int = CYCLE_LIMIT, threads: int | None = None
    ) -> JobResult:
        """Carry it out (see `Job.simulate`); `value` is what the kernel returns."""
        result = self.job.simulate(engine=engine, cycle_limit=cycle_limit, threads=threads)
        return replace(result, value=self._value(result))

    def _value(self, result: JobResult) -> Any:
        parallel, dtype = self.program.parallel, self.program.returns
        raised = next((word for word in self.errors if word[0]), None)
        if raised is not None:
            self.arrays[error_of(self.program)][:] = raised
        value = returned_value(self.program, self.arrays, self.inputs)
        if dtype is None:
            return value
        if parallel is None or parallel.result is None:
            return result.values[self.runs[0]]
        how = parallel.reductions[parallel.result]
        words = [result.words[run] for run in self.runs]
        if how.op == WIDE_LOW:
            return returned(dtype, functools.reduce(functools.partial(combined, how), words))
        # Words: a 64-bit integer that one word holds comes back extended.
        lows = [word & WORD_MASK for word in words]
        total = functools.reduce(functools.partial(combined, how), lows)
        has_high = self.program.return_high is not None
        return returned(dtype, total if has_high else joined(dtype, total, None))


def error_of(program: Program) -> str:
    """The array that says which exception a chunk raised; "" if a spread kernel raises none."""
    is_spread = program.parallel is not None and program.results is not None
    return program.results.error if is_spread and program.results is not None else ""


def combined(how: Reduction, total: int, partial: int) -> int:
    """A reduction's total with one more partial result."""
    if how.op == WIDE_LOW:
        return (total + partial) % (1 << 64)
    op = Opcode(how.op)
    if how.taken is None:
        return evaluate(op, (total, partial))
    pair = (total, partial) if how.swapped else (partial, total)
    return partial if bool(evaluate(op, pair)) is how.taken else total


class _Builder:
    """Makes the steps of a plan.

    Arrays keep their indices: the base address of a slice is that of its array's first element,
    which need not lie in the scratchpad.
    """

    def __init__(
        self, job: Job, cut: Cut, plan: Plan, arrays: ReadOnly[str, NDArray[np.generic]]
    ) -> None:
        self._job = job
        self._cut = cut
        self._plan = plan
        self._program = cut.program
        self._arrays = arrays
        self._places: dict[tuple[str, int], int] = {}
        self._free = 0
        self._inputs: dict[str, int] = {**cut.inputs}
        self._extents: dict[str, tuple[int, int]] = {}
        self._error = error_of(cut.program)
        self._errors: list[NDArray[np.generic]] = []

    def build(self, options: SpreadOptions) -> Spread:
        self._place()
        deal = self._dealt(options)
        self._tiles = tuple(sorted(set(deal.tiles)))
        self._turns = Turns(deal.tiles, self._plan.copies)
        for tile in self._tiles:  # each begins as soon as it has the program
            self._job.configure(tile, self._program)
        common = [self._broadcast(name, part) for name, part in self._plan.resident.items()]
        runs = []
        for number, chunk in enumerate(self._plan.chunks):
            runs.append(self._chunk(chunk, self._words(chunk, number), common))
        return Spread(
            self._job,
            self._program,
            self._plan,
            tuple(runs),
            self._cut.inputs,
            self._arrays,
            tuple(self._errors),
            deal.cycles or None,
        )

    def _words(self, chunk: Chunk, number: int) -> dict[str, int]:
        """Launch words of a chunk."""
        parallel = self._program.parallel
        if parallel is None:
            return {}
        starts = start_words(parallel, self._cut.inputs)
        words = chunk_inputs(parallel, chunk.first, chunk.last, starts, number == 0)
        return {**words, **chunk.words}

    def _dealt(self, options: SpreadOptions) -> Dealt:
        """The tiles of the chunks; no cycles are predicted of tiles in turn."""
        count = len(self._plan.chunks)
        tiles = len(self._job.accelerator.tiles)
        in_turn = Dealt(tuple(n % min(options.tiles or tiles, tiles) for n in range(count)), 0)
        if options.tiles is not None or options.chunk is not None or count == 1:
            return in_turn
        runs = [self._run_cycles(number) for number in probed(self._plan)]
        if not all(runs):
            return in_turn
        words = int(self._program.images_set.sum()) + len(self._program.launch)
        costs = costs_of(self._cut, self._plan, words, max(runs))
        return dealt(costs, self._plan.copies, tiles)

    def _run_cycles(self, number: int) -> int:
        """Cycles of a chunk's run; 0 if it fails."""
        chunk = self._plan.chunks[number]
        memory = np.zeros(self._cut.scratchpad.words, np.uint32)
        inputs, extents = {**self._inputs, **self._words(chunk, number)}, {**self._extents}
        held = [(name, part, extents[name][0]) for name, part in self._plan.resident.items()]
        held += self._slices(chunk, 0, inputs, extents)
        for name, part, address in held:
            if name in self._arrays:
                bytes_ = self._view(name, part).view(np.uint8)
                memory.view(np.uint8)[address : address + len(bytes_)] = bytes_
        for local in self._program.locals:
            if local.contents:
                local.fill(memory, extents[local.name][0])
        if self._error:
            place = self._places[self._error, 0]
            inputs[f"&{self._error}"], extents[self._error] = place, (place, place + WORD_BYTES)
        launch = Launch(memory, inputs, CYCLE_LIMIT, extents)
        try:
            return shared_tile(self._program).run(launch).cycles
        except SimulationError:
            return 0

    def _place(self) -> None:
        """Resident arrays, the kernel's own, then the slices, once or twice."""
        more = slack(self._cut.scratchpad)
        for name, part in self._plan.resident.items():
            self._places[name, 0] = self._take(part[1] - part[0] + more)
            address = self._address(name, 0, part[0])
            self._set(self._inputs, self._extents, name, address, part)
        for name, size in self._cut.local_sizes.items():
            address = self._take(size)
            self._inputs[f"&{name}"] = address
            self._extents[name] = (address, address + size)
        for half in range(self._plan.copies):
            if self._error:
                self._places[self._error, half] = self._take(WORD_BYTES)
            for name, size in self._plan.sliced.items():
                self._places[name, half] = self._take(size + more)

    def _take(self, size: int) -> int:
        address = self._free
        self._free += size
        return address

    def _address(self, name: str, half: int, first_byte: int) -> int:
        """Where word-aligned bytes of an array from `first_byte` on lie, so that its elements are
        in the banks that the compiler wished for.
        """
        banks = self._cut.scratchpad.banks
        place = self._places[name, half] // WORD_BYTES
        wish = self._program.banks.get(name, 0) + first_byte // WORD_BYTES
        return WORD_BYTES * (place + (wish - place) % banks)

    def _broadcast(self, name: str, part: Interval) -> int:
        return self._job.move_in(self._tiles, self._view(name, part), self._extents[name][0])

    def _set(
        self,
        inputs: dict[str, int],
        extents: dict[str, tuple[int, int]],
        name: str,
        address: int,
        part: Interval,
    ) -> None:
        inputs[f"&{name}"] = (address - part[0]) & WORD_MASK
        end = min(part[1], self._cut.sizes[name])
        extents[name] = (address, address + end - part[0])

    def _view(self, name: str, part: Interval) -> NDArray[np.generic]:
        """Bytes of an array as a view of its elements, of complex ones as one of their parts."""
        flat = self._arrays[name].reshape(-1)
        flat = flat.view(np.float32) if flat.dtype.kind == "c" else flat
        return flat[part[0] // flat.itemsize : -(-part[1] // flat.itemsize)]

    def _chunk(self, chunk: Chunk, words: dict[str, int], common: Sequence[int]) -> int:
        tile, half, before = self._turns.take()
        inputs, extents = {**self._inputs, **words}, {**self._extents}
        moves = list(common)
        for name, hull, address in self._slices(chunk, half, inputs, extents):
            if name in chunk.overwritten or not self._is_moved(name, chunk):
                moves += before
                continue
            view = self._view(name, hull)
            moves.append(self._job.move_in(tile, view, address, after=before))
        stores: dict[str, tuple[int, int]] = {}
        if self._error:
            moves.append(self._own_error(tile, half, before, inputs, extents))
            stores[self._error] = extents[self._error]
        for name, touch in chunk.touches.items():
            if touch.stores is not None and touch.hull is not None:
                start, _ = aligned(touch.hull)
                place = self._address(name, half, start) - start
                stores[name] = (place + touch.stores[0], place + touch.stores[1])
        run = self._job.execute(tile, self._program, inputs, extents, stores, after=moves)
        moved = {
            name: source
            for name, (source, _) in stores.items()
            if name == self._error or self._is_moved(name, chunk)
        }
        done = [self._moved_out(tile, chunk, name, source, run) for name, source in moved.items()]
        self._turns.free(tile, half, run, *done)
        return run

    def _slices(
        self, chunk: Chunk, half: int, inputs: dict[str, int], extents: dict[str, tuple[int, int]]
    ) -> Iterator[tuple[str, Interval, int]]:
        """Say where the slices of a chunk lie, in `inputs` and `extents`; the name, the bytes of
        the array, and the address of the first, of each.
        """
        for name in self._cut.sizes:
            hull = chunk.touches[name].hull
            if name in self._plan.resident:
                continue
            if hull is None:
                inputs[f"&{name}"], extents[name] = 0, (0, 0)
                continue
            start, _ = part = aligned(hull)
            address = self._address(name, half, start)
            self._set(inputs, extents, name, address, part)
            yield name, hull, address + hull[0] - start

    def _is_moved(self, name: str, chunk: Chunk) -> bool:
        """Whether what a chunk leaves in an array is for others: not in one of the kernel's own;
        of what all leave there alike, what the first leaves.
        """
        parallel = self._program.parallel
        alike = () if parallel is None else parallel.alike
        is_first = chunk is self._plan.chunks[0]
        return name in self._arrays and (name not in alike or is_first)

    def _moved_out(self, tile: int, chunk: Chunk, name: str, source: int, run: int) -> int:
        """Move out what a chunk has stored, or which exception it raised."""
        if name == self._error:
            return self._job.move_out(tile, source, self._errors[-1], after=[run])
        written = chunk.touches[name].stores
        assert written is not None
        return self._job.move_out(tile, source, self._view(name, written), after=[run])

    def _own_error(
        self,
        tile: int,
        half: int,
        before: Sequence[int],
        inputs: dict[str, int],
        extents: dict[str, tuple[int, int]],
    ) -> int:
        """Move in the word, 0, that says which exception a chunk raises."""
        address = self._places[self._error, half]
        inputs[f"&{self._error}"] = address
        extents[self._error] = (address, address + WORD_BYTES)
        self._errors.append(np.zeros_like(self._arrays[self._error]))
        return self._job.move_in(tile, self._errors[-1], address, after=before)
