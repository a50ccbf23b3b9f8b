"""Sorting of 3DGS on the array: by depth, then into the lists of screen tiles.

A pass counts digits (or rows, or columns) of chunks, turns the counts into places, and scatters
each chunk within a scratchpad; the runs of equal digits go to their places by DMA. The host reads
counts and places, which it needs to launch the transfers. Every pass is stable, so lists are in the
order of depth, and of the scene on ties.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch, Move
from vividc.render.array.device.launches import Phase, by_cost
from vividc.render.array.splats.project import DeviceSplats
from vividc.render.array.steering import CHUNKS_A_TILE, SHORTEST_CHUNK, SORTED_CHUNK
from vividc.render.arrays import Int32Array
from vividc.render.errors import SceneError

_FILE = "render/splat_sort"
_DIGIT_BITS = 6
_OUT_WORDS = 4800
"""Of what a chunk becomes in a launch; beside it lie a chunk and its counts."""
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

    @property
    def words(self) -> int:
        """Of all entries."""
        return sum(piece.size for piece in self.pieces)

    def moves(self) -> list[Move]:
        """Return its entries, one piece behind the other."""
        firsts = accumulate((piece.size for piece in self.pieces), initial=0)
        return [Move(piece, first) for piece, first in zip(self.pieces, firsts, strict=False)]


@dataclass(frozen=True, slots=True, eq=False)
class _Counted:
    """Counts and places [chunks, digits]; places are within the group of a chunk."""

    counts: Int32Array
    places: Int32Array
    totals: Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class _Scatter:
    """How a pass scatters: its kernel, words of what it writes, whether it takes part of digits."""

    kernel: str
    words: int
    scalars: Scalars
    ranged: bool


def sort_on_array(device: Device, splats: DeviceSplats, columns: int, rows: int) -> ScreenLists:
    """Sort the splats into the lists of `rows` x `columns` screen tiles.

    Raises
    ------
    SceneError
        They are more than the counts of their chunks have room for.
    """
    if len(splats) > SORTED_CHUNK * _PLACE_COUNTS:
        raise SceneError(
            f"{len(splats)} splats are seen, and the array sorts {SORTED_CHUNK * _PLACE_COUNTS}",
            hint="render a part of the scene, or use --engine reference",
        )
    ordered = _by_depth(device, splats)
    return _bin(device, ordered, columns, rows)


def _by_depth(device: Device, splats: DeviceSplats) -> Int32Array:
    """Return the entries [n, 3] by depth."""
    pieces = [splats.entries[first:last] for first, last in splats.spans()]
    bits = (splats.farthest - splats.nearest).bit_length()
    stage = "sorting"
    for shift in range(0, max(bits, 1), _DIGIT_BITS):
        chunks = _chunks(pieces, len(splats), device.tiles)
        scalars = {"least": splats.nearest, "shift": shift}
        counted = _count(device, stage, chunks, 1 << _DIGIT_BITS, "depth_counts", scalars)
        scatter = _Scatter("depth_scatter", 3, scalars, ranged=False)
        out = np.zeros((len(splats), 3), dtype=np.int32)
        _scatter(device, stage, chunks, counted, scatter, out)
        pieces = [out]
    return pieces[0]


def _bin(device: Device, ordered: Int32Array, columns: int, rows: int) -> ScreenLists:
    """Return the lists of screen tiles of entries that are in the order of depth."""
    stage = "binning"
    count = "span_counts"
    chunks = _chunks([ordered], len(ordered), device.tiles)
    counted = _count(device, stage, chunks, rows, count, {"words": 3, "shift": 0})
    by_row = np.zeros((int(counted.totals[0]), 2), dtype=np.int32)
    scatter = _Scatter("row_scatter", 2, {}, ranged=True)
    _scatter(device, stage, chunks, counted, scatter, by_row)

    starts = [*counted.places[0].tolist(), len(by_row)]
    lists = [by_row[first:last] for first, last in pairwise(starts)]
    share = -(-len(by_row) // (CHUNKS_A_TILE * device.tiles))
    length = min(SORTED_CHUNK, max(SHORTEST_CHUNK, share))
    chunks = [
        _Chunk((some,), row) for row, entries in enumerate(lists) for some in _cut(entries, length)
    ]
    scalars = {"words": 2, "shift": 16}
    counted = _count(device, stage, chunks, columns, count, scalars, rows)
    # A row's lists come behind those of the rows before.
    base = np.zeros(rows + 1, dtype=np.int32)
    np.cumsum(counted.totals, out=base[1:])
    counted.places[:] += base[[chunk.group for chunk in chunks]][:, None]
    slots = np.zeros(int(base[-1]), dtype=np.int32)
    scatter = _Scatter("column_scatter", 1, {}, ranged=True)
    _scatter(device, stage, chunks, counted, scatter, slots)
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
    length = min(SORTED_CHUNK, max(-(-total // tiles), 1))
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
    stage: str,
    chunks: Sequence[_Chunk],
    digits: int,
    kernel: str,
    scalars: Scalars,
    groups: int = 1,
) -> _Counted:
    """Count the digits of chunks, and turn the counts of each group into places."""
    counted = _Counted(
        counts=np.zeros((len(chunks), digits), dtype=np.int32),
        places=np.zeros((len(chunks), digits), dtype=np.int32),
        totals=np.zeros(groups, dtype=np.int32),
    )
    launches = [
        Launch(
            shapes={"entries": (chunk.words,)},
            inputs={"entries": chunk.moves()},
            outputs={"counts": counts},
            scalars={"n": len(chunk), **scalars},
            cost=len(chunk),
        )
        for chunk, counts in zip(chunks, counted.counts, strict=True)
    ]
    placed: list[list[Launch]] = [[] for _ in range(device.tiles)]
    for group in range(groups):
        members = [i for i, chunk in enumerate(chunks) if chunk.group == group]
        if members:
            span = slice(members[0], members[-1] + 1)
            placed[group % device.tiles] += _place(counted, group, span)
    phases = [
        Phase(f"{_FILE}:{kernel}", by_cost(launches, device.tiles)),
        Phase(f"{_FILE}:chunk_places", placed),
    ]
    device.run_phases(stage, phases)
    return counted


def _place(counted: _Counted, group: int, span: slice) -> Iterator[Launch]:
    """Yield what turns the counts of consecutive chunks into places, some digits at a time."""
    counts, places = counted.counts[span], counted.places[span]
    chunks, digits = counts.shape
    width = max(1, min(digits, _PLACE_COUNTS // chunks))
    total = counted.totals[group : group + 1]
    for first in range(0, digits, width):
        part = counts[:, first : first + width]
        yield Launch(
            inputs={"counts": part},
            outputs={"counts": places[:, first : first + width]},
            carried={"total": total},
            starts={"total": total},
            scalars={"chunks": chunks, "digits": part.shape[1]},
        )


def _scatter(
    device: Device,
    stage: str,
    chunks: Sequence[_Chunk],
    counted: _Counted,
    how: _Scatter,
    out: Int32Array,
) -> None:
    """Scatter chunks to the places of their digits in `out`."""
    launches: list[Launch] = []
    for number, chunk in enumerate(chunks):
        counts, entries = counted.counts[number], chunk.moves()
        for low, high in _ranges(counts, how):
            some = slice(low, high)
            made = int(counts[some].sum())
            launch = Launch(
                shapes={"entries": (chunk.words,), "out": (how.words * made,)},
                inputs={"counts": counts},
                outputs={"out": [*_runs(counts[some], counted.places[number][some], how, out)]},
                shared={"entries": entries},
                scalars={
                    "n": len(chunk),
                    **how.scalars,
                    **({"low": low, "high": high} if how.ranged else {}),
                },
                cost=len(chunk) + made,
            )
            launches.append(launch)
    device.run(stage, f"{_FILE}:{how.kernel}", launches)


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


def _runs(counts: Int32Array, places: Int32Array, how: _Scatter, out: Int32Array) -> Iterator[Move]:
    """Yield where the runs of equal digits go; what is in one piece there goes as one."""
    used = np.flatnonzero(counts)
    counts, places = counts[used], places[used]
    ends = np.cumsum(counts)
    begins = np.flatnonzero(np.append(True, places[1:] != places[:-1] + counts[:-1]))
    for first, last in pairwise((*begins.tolist(), len(used))):
        start, at = int(places[first]), int(ends[first] - counts[first])
        length = int(ends[last - 1]) - at
        yield Move(out[start : start + length], how.words * at)
