"""Sorting of 3DGS on the array: by depth, then into the lists of screen tiles.

A pass counts digits (or rows, or columns) of chunks, turns the counts into places, and scatters
each chunk within a scratchpad; the runs of equal digits go to their places by DMA. The host reads
counts and places, which it needs to launch the transfers. Every pass is stable, so lists are in the
order of depth, and of the scene on ties.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import vividc
from vividc.launch import At, Job
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.splats.project import DeviceSplats
from vividc.render.arrays import Int32Array
from vividc.render.errors import SceneError

_FILE = "render/splat_sort"
_DIGIT_BITS = 6
_CHUNK = 1024
"""Entries that a tile works on at once."""
_SPM_WORDS = 8192
_COUNTS_AT = 3 * _CHUNK
_OUT_AT = _COUNTS_AT + 256
_OUT_WORDS = _SPM_WORDS - _OUT_AT
_PLACE_COUNTS = 4096
"""Counts that are turned into places at once: at least one of each chunk."""

Scalars = Mapping[str, object]


@dataclass(frozen=True, slots=True, eq=False)
class ScreenLists:
    """The splats of each screen tile, front to back, in DRAM.

    Attributes
    ----------
    slots
        [entries] int32 rows of `DeviceSplats.rows`, grouped by screen tile, row-major.
    start
        [tiles + 1] where each tile's list begins.
    """

    slots: Int32Array
    start: Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class _Chunk:
    """What a tile works on at once: pieces of entries, one behind the other, of one group."""

    pieces: tuple[Int32Array, ...]
    group: int = 0

    def __len__(self) -> int:
        return sum(len(piece) for piece in self.pieces)


@dataclass(frozen=True, slots=True, eq=False)
class _Counted:
    """Counts and places [chunks, digits]; places are within the group of a chunk."""

    counts: Int32Array
    places: Int32Array
    totals: Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class _Scatter:
    """How a pass scatters: its kernel, words of what it writes, whether it takes part of digits."""

    program: vividc.Program
    words: int
    scalars: Scalars
    ranged: bool


def sort_on_array(
    device: Device, ledger: Ledger, splats: DeviceSplats, columns: int, rows: int
) -> ScreenLists:
    """Sort the splats into the lists of `rows` x `columns` screen tiles.

    Raises
    ------
    SceneError
        They are more than the counts of their chunks have room for.
    """
    if len(splats) > _CHUNK * _PLACE_COUNTS:
        raise SceneError(
            f"{len(splats)} splats are seen, and the array sorts {_CHUNK * _PLACE_COUNTS}",
            hint="render a part of the scene, or use --engine reference",
        )
    ordered = _by_depth(device, ledger, splats)
    return _bin(device, ledger, ordered, columns, rows)


def _by_depth(device: Device, ledger: Ledger, splats: DeviceSplats) -> Int32Array:
    """Return the entries [n, 3] by depth."""
    pieces = [splats.entries[first:last] for first, last in splats.spans()]
    bits = (splats.farthest - splats.nearest).bit_length()
    stage = "sorting"
    for shift in range(0, max(bits, 1), _DIGIT_BITS):
        chunks = _chunks(pieces, len(splats), device.tiles)
        scalars = {"least": splats.nearest, "shift": shift}
        count = device.programs.get(f"{_FILE}:depth_counts")
        counted = _count(device, ledger, stage, chunks, 1 << _DIGIT_BITS, count, scalars)
        scatter = _Scatter(device.programs.get(f"{_FILE}:depth_scatter"), 3, scalars, ranged=False)
        out = np.zeros((len(splats), 3), dtype=np.int32)
        _scatter(device, ledger, stage, chunks, counted, scatter, out)
        pieces = [out]
    return pieces[0]


def _bin(
    device: Device, ledger: Ledger, ordered: Int32Array, columns: int, rows: int
) -> ScreenLists:
    """Return the lists of screen tiles of entries that are in the order of depth."""
    stage = "binning"
    count = device.programs.get(f"{_FILE}:span_counts")
    chunks = _chunks([ordered], len(ordered), device.tiles)
    counted = _count(device, ledger, stage, chunks, rows, count, {"words": 3, "shift": 0})
    by_row = np.zeros((int(counted.totals[0]), 2), dtype=np.int32)
    scatter = _Scatter(device.programs.get(f"{_FILE}:row_scatter"), 2, {}, ranged=True)
    _scatter(device, ledger, stage, chunks, counted, scatter, by_row)

    starts = [*counted.places[0].tolist(), len(by_row)]
    lists = [by_row[first:last] for first, last in pairwise(starts)]
    chunks = [
        _Chunk((some,), row) for row, entries in enumerate(lists) for some in _cut(entries, _CHUNK)
    ]
    scalars = {"words": 2, "shift": 16}
    counted = _count(device, ledger, stage, chunks, columns, count, scalars, rows)
    # A row's lists come behind those of the rows before.
    base = np.zeros(rows + 1, dtype=np.int32)
    np.cumsum(counted.totals, out=base[1:])
    counted.places[:] += base[[chunk.group for chunk in chunks]][:, None]
    slots = np.zeros(int(base[-1]), dtype=np.int32)
    scatter = _Scatter(device.programs.get(f"{_FILE}:column_scatter"), 1, {}, ranged=True)
    _scatter(device, ledger, stage, chunks, counted, scatter, slots)
    return ScreenLists(slots, _starts(chunks, counted.places, base, columns))


def _starts(
    chunks: Sequence[_Chunk], places: Int32Array, base: Int32Array, columns: int
) -> Int32Array:
    """Where the list of each screen tile begins: the place of its row's first chunk."""
    start = np.repeat(base[:-1], columns).reshape(-1, columns)
    for number in reversed(range(len(chunks))):
        start[chunks[number].group] = places[number]
    return np.append(start.ravel(), base[-1]).astype(np.int32)


def _chunks(pieces: Sequence[Int32Array], total: int, tiles: int) -> list[_Chunk]:
    """Cut pieces, in order, into chunks of the same length, at least one for each tile."""
    length = min(_CHUNK, max(-(-total // tiles), 1))
    chunks: list[_Chunk] = []
    held: list[Int32Array] = []
    room = length
    for piece in pieces:
        while len(piece):
            held.append(piece[:room])
            piece = piece[len(held[-1]) :]  # noqa: PLW2901 - what is left of it
            room -= len(held[-1])
            if room == 0:
                chunks.append(_Chunk(tuple(held)))
                held, room = [], length
    if held:
        chunks.append(_Chunk(tuple(held)))
    return chunks


def _cut(entries: Int32Array, length: int) -> Iterator[Int32Array]:
    for start in range(0, len(entries), length):
        yield entries[start : start + length]


def _count(
    device: Device,
    ledger: Ledger,
    stage: str,
    chunks: Sequence[_Chunk],
    digits: int,
    program: vividc.Program,
    scalars: Scalars,
    groups: int = 1,
) -> _Counted:
    """Count the digits of chunks, and turn the counts of each group into places."""
    counted = _Counted(
        counts=np.zeros((len(chunks), digits), dtype=np.int32),
        places=np.zeros((len(chunks), digits), dtype=np.int32),
        totals=np.zeros(groups, dtype=np.int32),
    )
    job = device.new_job()
    tiles = device.tiles
    last: dict[int, list[int]] = {}
    for number, chunk in enumerate(chunks):
        tile = number % tiles
        entries, moves = _move_in(job, tile, chunk, last.get(tile, []))
        run = job.run(
            tile,
            program,
            entries=At(0, (entries,)),
            n=len(chunk),
            counts=At(WORD_BYTES * _COUNTS_AT, (digits,)),
            after=[*moves, *last.get(tile, [])],
            **scalars,
        )
        counts = counted.counts[number]
        last[tile] = [job.move_out(tile, WORD_BYTES * _COUNTS_AT, counts, after=[run])]
    done = [step for steps in last.values() for step in steps]
    for group in range(groups):
        members = [i for i, chunk in enumerate(chunks) if chunk.group == group]
        if members:
            span = slice(members[0], members[-1] + 1)
            tile = group % tiles
            last[tile] = _place(
                device, job, tile, counted, group, span, [*done, *last.get(tile, [])]
            )
    device.finish(ledger, stage, job)
    return counted


def _place(
    device: Device,
    job: Job,
    tile: int,
    counted: _Counted,
    group: int,
    span: slice,
    after: Sequence[int],
) -> list[int]:
    """Add the steps that turn counts of consecutive chunks into places."""
    program = device.programs.get(f"{_FILE}:chunk_places")
    counts = counted.counts[span]
    chunks, digits = counts.shape
    width = max(1, min(digits, _PLACE_COUNTS // chunks))
    total_at = WORD_BYTES * _PLACE_COUNTS
    steps = [job.move_in(tile, counted.totals[group : group + 1], total_at, after=after)]
    for first in range(0, digits, width):
        some = slice(first, min(first + width, digits))
        part = counts[:, some]
        moved = job.move_in(tile, part, 0, after=[*after, *steps])
        run = job.run(
            tile,
            program,
            counts=At(0, (part.size,)),
            chunks=chunks,
            digits=part.shape[1],
            total=At(total_at, (1,)),
            after=[moved, *steps],
        )
        steps = [job.move_out(tile, 0, counted.places[span][:, some], after=[run])]
    steps.append(job.move_out(tile, total_at, counted.totals[group : group + 1], after=steps))
    return steps


def _scatter(
    device: Device,
    ledger: Ledger,
    stage: str,
    chunks: Sequence[_Chunk],
    counted: _Counted,
    how: _Scatter,
    out: Int32Array,
) -> None:
    """Scatter chunks to the places of their digits in `out`."""
    job = device.new_job()
    tiles = device.tiles
    last: dict[int, list[int]] = {}
    for number, chunk in enumerate(chunks):
        tile = number % tiles
        entries, here = _move_in(job, tile, chunk, last.get(tile, []))
        for low, high in _ranges(counted.counts[number], how):
            before = [*last.get(tile, []), *here]
            digits = counted.counts[number]
            moved = job.move_in(tile, digits, WORD_BYTES * _COUNTS_AT, after=before)
            bounds = {"low": low, "high": high} if how.ranged else {}
            total = int(digits[low:high].sum())
            run = job.run(
                tile,
                how.program,
                entries=At(0, (entries,)),
                n=len(chunk),
                counts=At(WORD_BYTES * _COUNTS_AT, (len(digits),)),
                out=At(WORD_BYTES * _OUT_AT, (how.words * total,)),
                after=[moved, *before],
                **how.scalars,
                **bounds,
            )
            places = counted.places[number]
            last[tile] = _move_out(job, tile, run, digits, places, (low, high), how.words, out)
            here = []
    device.finish(ledger, stage, job)


def _move_in(job: Job, tile: int, chunk: _Chunk, after: Sequence[int]) -> tuple[int, list[int]]:
    """Bring the pieces of a chunk; return their words and the steps."""
    steps, at = [], 0
    for piece in chunk.pieces:
        steps.append(job.move_in(tile, piece, WORD_BYTES * at, after=after))
        at += piece.size
    return at, steps


def _ranges(counts: Int32Array, how: _Scatter) -> Iterator[tuple[int, int]]:
    """Yield ranges of digits whose entries fit a scratchpad."""
    if not how.ranged:
        yield 0, len(counts)
        return
    most = _OUT_WORDS // how.words
    low, held = 0, 0
    for digit, count in enumerate(counts.tolist()):
        if held + count > most:
            yield low, digit
            low, held = digit, 0
        held += count
    if held:
        yield low, len(counts)


def _move_out(
    job: Job,
    tile: int,
    run: int,
    counts: Int32Array,
    places: Int32Array,
    digits: tuple[int, int],
    words: int,
    out: Int32Array,
) -> list[int]:
    """Move runs of equal digits to their places; what is in one piece there goes as one."""
    steps = []
    at, start, length = _OUT_AT, 0, 0
    for digit in range(*digits):
        count, place = int(counts[digit]), int(places[digit])
        if count == 0:
            continue
        if place != start + length and length:
            target = out[start : start + length]
            steps.append(job.move_out(tile, WORD_BYTES * at, target, after=[run]))
            at, length = at + words * length, 0
        start = start if length else place
        length += count
    target = out[start : start + length]
    steps.append(job.move_out(tile, WORD_BYTES * at, target, after=[run]))
    return steps
