"""A kernel's parallel loop over all tiles: a launch graph made from its arguments."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.errors import ArgumentError
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
from vividc.launch.turns import Turns
from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import WIDE_LOW, Reduction
from vividc.machine.semantics import evaluate
from vividc.machine.words import WORD_MASK
from vividc.program import WORD_BYTES, Program, joined
from vividc.sim.bind import arguments, returned
from vividc.sim.footprint.footprint import chunk_inputs, start_words
from vividc.sim.run import CYCLE_LIMIT, returned_value
from vividc.sim.tile import AUTO


@dataclass(frozen=True, slots=True)
class SpreadOptions:
    """How a loop is spread.

    Attributes
    ----------
    chunk
        Iterations of a chunk; None: as suits the scratchpads.
    double_buffer
        Slices move into one half of a scratchpad while the tile works on the other.
    """

    chunk: int | None = None
    double_buffer: bool = True


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
    sizes = {name: array.nbytes for name, array in arrays.items()}
    sliced = () if program.parallel is None else program.parallel.sliced
    own = own_sizes(program, inputs)
    sizes |= {name: own[name] for name in sliced}
    cut = Cut(program, inputs, sizes, job.accelerator, options.double_buffer)
    plan = plan_chunks(cut, options.chunk)
    return _Builder(job, cut, plan, arrays).build()


@dataclass(frozen=True, slots=True)
class Spread:
    """A spread launch: the job, and the run of each chunk in the order of iterations."""

    job: Job
    program: Program
    plan: Plan
    runs: tuple[int, ...]
    inputs: ReadOnly[str, int]
    arrays: ReadOnly[str, NDArray[np.generic]]

    def simulate(
        self, *, engine: str = AUTO, cycle_limit: int = CYCLE_LIMIT, threads: int | None = None
    ) -> JobResult:
        """Carry it out (see `Job.simulate`); `value` is what the kernel returns."""
        result = self.job.simulate(engine=engine, cycle_limit=cycle_limit, threads=threads)
        return replace(result, value=self._value(result))

    def _value(self, result: JobResult) -> Any:
        parallel, dtype = self.program.parallel, self.program.returns
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
        self._tiles = tuple(range(min(len(job.accelerator.tiles), len(plan.chunks))))
        self._places: dict[tuple[str, int], int] = {}
        self._free = 0
        self._inputs: dict[str, int] = {**cut.inputs}
        self._extents: dict[str, tuple[int, int]] = {}
        self._turns = Turns(self._tiles, plan.copies)

    def build(self) -> Spread:
        self._job.configure(self._tiles, self._program)
        self._place()
        common = [self._broadcast(name, part) for name, part in self._plan.resident.items()]
        parallel = self._program.parallel
        starts = () if parallel is None else start_words(parallel, self._cut.inputs)
        runs = []
        for number, chunk in enumerate(self._plan.chunks):
            words: dict[str, int] = {}
            if parallel is not None:
                words = chunk_inputs(parallel, chunk.first, chunk.last, starts, number == 0)
                words |= chunk.words
            runs.append(self._chunk(chunk, words, common))
        inputs = self._cut.inputs
        return Spread(self._job, self._program, self._plan, tuple(runs), inputs, self._arrays)

    def _place(self) -> None:
        """Resident arrays, the kernel's own, then the slices, once or twice."""
        more = slack(self._cut.scratchpad)
        for name, (start, end) in self._plan.resident.items():
            self._places[name, 0] = self._take(end - start + more)
        for name, size in self._cut.local_sizes.items():
            address = self._take(size)
            self._inputs[f"&{name}"] = address
            self._extents[name] = (address, address + size)
        for half in range(self._plan.copies):
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
        address = self._address(name, 0, part[0])
        self._set(self._inputs, self._extents, name, address, part)
        view = self._view(name, part)
        return self._job.move_in(self._tiles, view, address)

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
            if name in chunk.overwritten or name not in self._arrays:
                moves += before
                continue
            view = self._view(name, hull)
            moves.append(self._job.move_in(tile, view, address + hull[0] - start, after=before))
        stores = {}
        for name, touch in chunk.touches.items():
            if touch.stores is not None and touch.hull is not None:
                start, _ = aligned(touch.hull)
                place = self._address(name, half, start) - start
                stores[name] = (place + touch.stores[0], place + touch.stores[1])
        run = self._job.execute(tile, self._program, inputs, extents, stores, after=moves)
        done = [run]
        for name, (source, _) in stores.items():
            if name not in self._arrays:
                continue
            written = chunk.touches[name].stores
            assert written is not None
            view = self._view(name, written)
            done.append(self._job.move_out(tile, source, view, after=[run]))
        self._turns.free(tile, half, *done)
        return run
