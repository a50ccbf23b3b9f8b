"""A product of matrices in DRAM, cut to what the scratchpads hold: blocks of rows and of columns,
and parts of the inner dimension.

A matrix lies in DRAM as *stacks*: blocks of as many rows as an array has, column by column, float32
[blocks, columns, rows of a block], filled up with zeros. So an array reads the left operand; the
right one it reads as its transpose. What it makes are stacks of the result; what sums start from,
if that is a matrix, it reads as stacks of the transpose. The transposed product of the transposed
operands reads the same and makes the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil

import numpy as np
from numpy.typing import NDArray

from vividc.arch import Accelerator
from vividc.gemm.chain import START_CONTEXTS, Chain, Link, chain_program
from vividc.gemm.modes import FABRICS, Mode, array_of
from vividc.gemm.passes import units
from vividc.gemm.program import LINE, Shape
from vividc.gemm.systolic import (
    BUFFER,
    GROUP_BYTES,
    TABLE_ROW,
    Form,
    Stream,
    SystolicArray,
    SystolicError,
)
from vividc.launch import At, Job
from vividc.launch.turns import Turns
from vividc.program import WORD_BYTES

Stacks = NDArray[np.float32]

_WAITS = 4
"""Transfers that each part of the inner dimension waits for one after the other."""

_PARTS_OF_DEPTH = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64)
"""Parts of the inner dimension that are tried."""


def stacked(matrix: NDArray[np.float32], size: int) -> Stacks:
    """A matrix as stacks of `size` rows, its columns too filled up with zeros."""
    rows, cols = (ceil(n / size) * size for n in matrix.shape)
    whole = np.zeros((rows, cols), np.float32)
    whole[: matrix.shape[0], : matrix.shape[1]] = matrix
    return np.ascontiguousarray(whole.reshape(-1, size, cols).transpose(0, 2, 1))


def unstacked(stacks: Stacks, rows: int, cols: int) -> NDArray[np.float32]:
    """The matrix of this size that lies in stacks."""
    return stacks.transpose(0, 2, 1).reshape(-1, stacks.shape[1])[:rows, :cols]


@lru_cache(maxsize=1024)
def _shape(mode: Mode, tile_bytes: int, form: Form, words: int) -> Shape:
    return Shape.of(array_of(mode, tile_bytes), form, words)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Rows, columns and inner indices of a product."""

    rows: int
    cols: int
    depth: int

    @property
    def terms(self) -> int:
        """Products of two elements."""
        return self.rows * self.cols * self.depth

    @property
    def swapped(self) -> Sizes:
        """Of the transposed product."""
        return Sizes(self.cols, self.rows, self.depth)


@dataclass(frozen=True)
class Tiling:
    """How a product is cut.

    Attributes
    ----------
    tile_bytes
        Of a tile's scratchpad; an array joins those of its tiles.
    depths
        Lengths of the parts of the inner dimension; the sums of all but the first start from what
        the one before made, and those of the first, if it is not all, from a matrix.
    rows, bands
        Blocks of rows and of columns of a run, at most.
    parts
        Equal parts of a scratchpad, each with all operands of a run.
    relu
        max(x, 0) of the results.
    added
        Sums start from a matrix, and not from a bias.
    """

    mode: Mode
    tile_bytes: int
    sizes: Sizes
    depths: tuple[int, ...]
    rows: int
    bands: int
    parts: int
    relu: bool
    added: bool

    @property
    def array(self) -> SystolicArray:
        """The array that runs it."""
        return array_of(self.mode, self.tile_bytes)

    def form(self, part: int) -> Form:
        """What the array computes of a part of the inner dimension."""
        is_last = part == len(self.depths) - 1
        return Form(self.depths[part], self.relu and is_last, added=self.added)

    def shape(self, part: int) -> Shape:
        """The program's form.

        Raises
        ------
        SystolicError
            It does not fit.
        """
        return _shape(self.mode, self.tile_bytes, self.form(part), self.words)

    def is_swapped(self, part: int) -> bool:
        """Whether a part makes the transposed result, so that the last one does not."""
        return (len(self.depths) - 1 - part) % 2 == 1

    def at(self, part: int) -> Sizes:
        """Sizes of what a part computes."""
        sizes = self.sizes.swapped if self.is_swapped(part) else self.sizes
        return Sizes(sizes.rows, sizes.cols, self.depths[part])

    def chain(self, part: int, bands: int) -> Chain:
        """The program of runs with this many blocks of columns."""
        return Chain(self.array, (Link(self.form(part), bands),), self.parts)

    def band_size(self, part: int) -> int:
        """Elements of a block of columns of the right operand, with its bias."""
        return (self.depths[part] + (not self.added)) * self.array.cols

    def runs(self, part: int) -> Iterator[tuple[range, range]]:
        """Blocks of columns and of rows of each run."""
        sizes, side = self.at(part), self.array.rows
        bands, blocks = ceil(sizes.cols / side), ceil(sizes.rows / side)
        for band in range(0, bands, self.bands):
            for block in range(0, blocks, self.rows):
                yield (
                    range(band, min(band + self.bands, bands)),
                    range(block, min(block + self.rows, blocks)),
                )

    def cycles(self, machine: Accelerator) -> int:
        """About how many the job takes: runs hide behind transfers, or transfers behind runs."""
        wait = machine.dma.setup_cycles + machine.dram.latency + machine.noc.latency
        total, configured = _WAITS * wait * len(self.depths), 0
        arrays = FABRICS[self.mode][1]
        for part in range(len(self.depths)):
            busy, moved = self._spent(part, machine)
            total += ceil(max(busy, moved) if self.parts > 1 else busy + moved)
            if part == 0 or self.form(part) != self.form(part - 1):
                contexts = self.shape(part).ii + START_CONTEXTS
                configured += arrays * len(self.array.fabric.pes) * contexts
        return total + configured // machine.configuration.entries_per_cycle

    def _spent(self, part: int, machine: Accelerator) -> tuple[float, float]:
        """Cycles of a part's runs on the array with most of them, and of its transfers."""
        side, arrays = self.array.rows, FABRICS[self.mode][1]
        sizes, depth = self.at(part), self.depths[part]
        line = self.array.fabric.scratchpad.banks // (GROUP_BYTES // WORD_BYTES)
        shape = self.shape(part)
        busy, words, runs = 0.0, 0.0, 0
        for bands, groups in _pieces(ceil(sizes.cols / side), self.bands):
            pieces = _pieces(ceil(sizes.rows / side), self.rows)
            again = sum(count for _, count in pieces)
            loaded = min(again, self.parts * arrays) / again
            for blocks, count in pieces:
                tiles = bands * blocks
                own = loaded * bands * self.band_size(part)
                own += (blocks * depth + tiles * side * (1 + self.added)) * side
                busy += groups * count * (shape.cycles(tiles) + own / line)
                words += groups * count * own
                runs += groups * count
        share = busy / runs * ceil(runs / arrays)
        return share, words * WORD_BYTES / machine.dram.bytes_per_cycle

    @property
    def words(self) -> int:
        """Words of a part of the scratchpad."""
        return self.array.fabric.scratchpad.words // self.parts


def tiled(
    sizes: Sizes, mode: Mode, machine: Accelerator, *, relu: bool = False, added: bool = False
) -> Tiling:
    """The way to cut a product that is estimated to take the fewest cycles.

    Raises
    ------
    SystolicError
        A product of one block of rows and one of columns does not fit.
    """
    best, refusal = None, None
    tile_bytes = machine.fabric.scratchpad.size_bytes
    for count in _PARTS_OF_DEPTH:
        if count > sizes.depth:
            break
        for parts in (2, 1):
            depths = _cut(sizes.depth, count)
            try:
                whole = added or len(depths) > 1
                first = Tiling(mode, tile_bytes, sizes, depths, 1, 1, parts, relu, whole)
                found = _filled(first)
            except SystolicError as error:
                refusal = refusal or error
                continue
            for one in found:
                cycles = one.cycles(machine)
                if best is None or cycles < best[0]:
                    best = cycles, one
    if best is None:
        assert refusal is not None
        raise refusal
    return best[1]


def _cut(depth: int, count: int) -> tuple[int, ...]:
    """A length in parts, all but the last alike, which may be shorter."""
    size = ceil(depth / count)
    whole, rest = divmod(depth, size)
    return (size,) * whole + ((rest,) if rest else ())


def _filled(tiling: Tiling) -> Iterator[Tiling]:
    """With as many blocks of rows as fit, for several numbers of blocks of columns."""
    side = tiling.array.rows
    room = tiling.words // (GROUP_BYTES // WORD_BYTES)
    depth = max(tiling.depths)
    for part in range(len(tiling.depths)):
        tiling.shape(part)  # raises what does not fit
    blocks = max(ceil(tiling.at(p).rows / side) for p in range(len(tiling.depths)))
    most = max(ceil(tiling.at(p).cols / side) for p in range(len(tiling.depths)))
    band = max(map(tiling.band_size, range(len(tiling.depths))))
    made = []
    for bands in sorted({min(2**n, most) for n in range(most.bit_length() + 1)}):
        left = room - bands * band
        rows = min(
            room // (depth * side), room // (bands * side * side), room // (TABLE_ROW * bands)
        )
        if tiling.added:
            rows = min(rows, left // (bands * side * side))
        share = ceil(blocks / FABRICS[tiling.mode][1])
        rows = min(rows, share)
        if left < 0 or rows < 1:
            continue
        made.append(replace(tiling, rows=rows, bands=bands))
        half = ceil(share / ceil(share / rows) / 2)
        if half < rows:
            made.append(replace(tiling, rows=half, bands=bands))
    return iter(made)


def _pieces(length: int, size: int) -> list[tuple[int, int]]:
    """Lengths of what a length is cut into, and how many there are of each."""
    whole, rest = divmod(length, size)
    return [(n, count) for n, count in ((size, whole), (rest, 1)) if n and count]


@dataclass(frozen=True)
class Operands:
    """What a product is made of, in DRAM.

    Attributes
    ----------
    left, right
        Stacks of the left matrix, and of the right one's transpose, this with the bias as a last
        column if sums start from one.
    start
        Stacks of the transpose of what sums start from, if that is a matrix.
    before, started
        Steps that write the matrices, and the start.
    """

    left: Stacks
    right: Stacks
    start: Stacks | None
    before: tuple[int, ...] = ()
    started: tuple[int, ...] = ()


def add_product(job: Job, tiling: Tiling, given: Operands) -> tuple[Stacks, tuple[int, ...]]:
    """Add the steps of a product to a job; return stacks of the result, filled once the job is
    simulated, and the steps that write them.

    With an even number of parts of the inner dimension the first one makes the transposed result:
    `given.start` is then of the other form, stacks of the matrix itself.
    """
    side = tiling.array.rows
    start, done, at = given.start, given.started, 0
    target = given.left
    turns = Turns(units(job.accelerator, tiling.mode), tiling.parts)
    for part, depth in enumerate(tiling.depths):
        sizes = tiling.at(part)
        blocks, width = ceil(sizes.rows / side), ceil(sizes.cols / side) * side
        target = np.zeros((blocks, width, side), np.float32)
        columns = slice(at, at + depth + (not tiling.added))
        left, right = given.left[:, at : at + depth], given.right[:, columns]
        if tiling.is_swapped(part):
            left, right = right, left
        here = Operands(left, right, start, given.before, done)
        done = _Part(job, tiling, part).add(here, target, turns)
        start = target
        at += depth
    return target, done


class _Part:
    """The steps of one part of the inner dimension."""

    def __init__(self, job: Job, tiling: Tiling, part: int) -> None:
        self._job = job
        self._tiling = tiling
        self._part = part
        self._program = chain_program(tiling.chain(part, 1))
        self._fixed: dict[tuple[int, int], tuple[range, int]] = {}
        self._tables: dict[tuple[int, int], tuple[tuple[int, int], int]] = {}

    def add(self, given: Operands, target: Stacks, turns: Turns) -> tuple[int, ...]:
        """Add all steps; return the numbers of the last ones."""
        job, tiling, side = self._job, self._tiling, self._tiling.array.rows
        runs = list(tiling.runs(self._part))
        found = units(job.accelerator, tiling.mode)[: len(runs)]
        if not job.holds(found, self._program):
            job.configure(found, self._program)
        done = []
        for bands, blocks in runs:
            unit, place, freed = turns.take()
            after = (*given.before, *freed)
            fixed = self._columns(unit, place, bands, given, after)
            after = (*after, fixed)
            after = (*after, self._table(unit, place, len(bands), len(blocks), after))
            rows, cols = _slice(blocks), _slice(bands, side)
            last = self._in(unit, place, Stream.A, 0, given.left[rows], after)
            if given.start is not None:
                tiles = given.start[_slice(bands), _slice(blocks, side)]
                first = len(bands) * tiling.band_size(self._part)
                waits = (*after, last, *given.started)
                last = self._in(unit, place, Stream.B, first, tiles, waits)
            ran = self._run(unit, place, len(bands), len(blocks), last)
            where = self._address(place, Stream.C)
            out = job.move_out(unit, where, target[rows, cols], after=[ran], pitch=GROUP_BYTES)
            turns.free(unit, place, out)
            done.append(out)
        return tuple(done)

    def _columns(
        self, unit: int, place: int, bands: range, given: Operands, after: tuple[int, ...]
    ) -> int:
        """The blocks of columns of the right operand, which stay for as long as they are used."""
        known = self._fixed.get((unit, place))
        if known is not None and known[0] == bands:
            return known[1]
        made = self._in(unit, place, Stream.B, 0, given.right[_slice(bands)], after)
        self._fixed[unit, place] = bands, made
        return made

    def _table(self, unit: int, place: int, bands: int, blocks: int, after: tuple[int, ...]) -> int:
        """Where the operands of each block lie."""
        known = self._tables.get((unit, place))
        if known is not None and known[0] == (bands, blocks):
            return known[1]
        made = self._in(unit, place, Stream.TABLE, 0, self._places(bands, blocks), after)
        self._tables[unit, place] = (bands, blocks), made
        return made

    def _places(self, bands: int, blocks: int) -> NDArray[np.uint32]:
        side, size = self._tiling.array.rows, self._tiling.band_size(self._part)
        block, band = np.divmod(np.arange(blocks * bands), bands)
        rows = np.zeros((block.size, TABLE_ROW), np.int64)
        rows[:, Stream.A] = block * self._tiling.depths[self._part] * side
        rows[:, Stream.B] = band * size
        rows[:, Stream.C] = (block * bands + band) * side * side
        rows[:, Stream.TABLE] = bands * size + (band * blocks + block) * side * side
        return (rows * GROUP_BYTES).astype(np.uint32).ravel()

    def _in(
        self,
        unit: int,
        place: int,
        stream: Stream,
        first: int,
        source: NDArray[np.generic],
        after: tuple[int, ...],
    ) -> int:
        where = self._address(place, stream) + first * GROUP_BYTES
        return self._job.move_in(unit, source, where, after=after, pitch=GROUP_BYTES)

    def _address(self, place: int, stream: Stream) -> int:
        return (place * self._tiling.words + stream) * WORD_BYTES

    def _run(self, unit: int, place: int, bands: int, blocks: int, last: int) -> int:
        words = self._tiling.words
        arguments: dict[str, object] = {
            BUFFER: At(place * words * WORD_BYTES, (words // LINE, LINE))
        }
        chain = self._tiling.chain(self._part, bands)
        arguments |= chain.scalars(place, blocks, (0,))
        return self._job.run(unit, self._program, after=[last], **arguments)


def _slice(items: range, times: int = 1) -> slice:
    return slice(items.start * times, items.stop * times)
