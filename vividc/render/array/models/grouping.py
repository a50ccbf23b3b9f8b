"""KiloNeRF's samples by network: each piece is sorted in a scratchpad, and what survives of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Final

import numpy as np

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launch import Gathered, Move, Words
from vividc.render.array.pieces import RAYS, Piece, Survivors, total
from vividc.render.array.records import (
    Fields,
    Kept,
    Listed,
    filled,
    items,
    of_all,
    of_pieces,
    of_samples,
)
from vividc.render.array.steering import GROUPED
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.radiance import KiloNeRF

_KERNELS: Final = "render/kilonerf"
_STAGE: Final = "grouping"
_SAMPLE_WORDS: Final = 11
"""Of a sample in a launch that sorts, or of survivors, with those of the next one."""
_RAY_WORDS: Final = 2 * 4
_NETWORK_WORDS: Final = 2
_LINES: Final = 24
"""Of arrays that begin in a certain bank there."""


Runs = Sequence[tuple[int, int, int]]
"""Network, first place and number of samples of one network in one piece."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Samples of one network that go through it together.

    Attributes
    ----------
    network
        Its number.
    places
        Where they are among all that are sorted.
    """

    network: int
    places: tuple[slice, ...]

    @property
    def count(self) -> int:
        """How many they are."""
        return sum(some.stop - some.start for some in self.places)

    def moves(
        self, table: Words, first: int = 0, rows: Int32Array | None = None
    ) -> tuple[Move, ...]:
        """Return their rows of a table, or those that sorted numbers of rows choose, one after the
        other from word `first` of an array on.
        """
        width = table[:1].nbytes // WORD_BYTES
        moves = []
        for some in self.places:
            chosen = table[some] if rows is None else Gathered(table, rows[some])
            moves.append(Move(chosen, first))
            first += width * (some.stop - some.start)
        return tuple(moves)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Samples in the order of networks, piece by piece.

    Attributes
    ----------
    local
        [n, 3] places in their networks' cells, -1 to 1.
    places
        [n] of each sample in that order, counted from its piece's first.
    starts
        By range of networks: its first one, and [pieces, networks + 2] where each network starts in
        each piece.
    runs
        Of all pieces.
    """

    local: Float32Array
    places: Int32Array
    starts: Sequence[tuple[int, Int32Array]]
    runs: Runs


@dataclass(frozen=True, slots=True, eq=False)
class KeptOfSamples:
    """Those that survive: `places` and `runs` as of `Samples`; in the order of networks the places
    among all samples, [n] `rows`, and [n] `rays`.
    """

    places: Int32Array
    rows: Int32Array
    rays: Int32Array
    runs: Runs


class Grouping:
    """Sorts pieces by the networks of a model.

    Attributes
    ----------
    most_samples
        That a piece may have.
    """

    def __init__(self, model: KiloNeRF, device: Device) -> None:
        self._device = device
        box, cells = model.march.box, model.network.shape
        scale = np.array(cells, dtype=np.float32) / (box[1] - box[0])
        table = np.ascontiguousarray(model.network, dtype=np.int32).reshape(-1)
        self._table = table
        self._fits = 2 * table.nbytes <= device.scratchpad_bytes
        self._shared: dict[str, Words] = {
            "box": np.concatenate((box[0], scale), dtype=np.float32),
            "grid": np.array(cells, dtype=np.int32),
            "networks": table if self._fits else table[:1],
        }
        self._count = len(model.weights[0]) + 1
        self._free = self._words_free()
        least, most = GROUPED
        by_sample = min(
            (words - counts * _NETWORK_WORDS * (self._count + 2)) // of_sample
            for counts, of_sample, words in self._free
        )
        self.most_samples = min(most, max(least, by_sample))
        self._ranges = list(self._ranges_in())

    def samples(self, listed: Listed) -> Samples:
        """Sort the samples of each piece by network, those without one first; of more networks than
        a scratchpad counts, a range after the other, in what the ranges before left.
        """
        pieces, count = listed.pieces, total(listed.pieces)
        local, places = np.zeros((count, 3), np.float32), np.zeros(count, np.int32)
        known = None if self._fits else of_samples(self._numbers(listed.points()))
        made = {"places": of_samples(places), "local": of_samples(local)}
        starts = []
        for low, networks in self._ranges:
            begins = np.zeros((len(pieces), networks + 2), dtype=np.int32)
            fields = Fields(
                reads={
                    **listed.of_rays,
                    "items": items,
                    "chosen": known,
                    **({} if low < 0 else made),
                },
                writes={"starts": of_pieces(begins), **made},
                shared={**self._shared, "geometry": listed.geometry},
                work={} if known else {"chosen": len},
                scalars=self._scalars(low),
                cost=lambda piece: len(piece) + RAYS,
            )
            fields.run(self._device, _STAGE, f"{_KERNELS}:group_samples", pieces)
            starts.append((low, begins))
        return Samples(local, places, starts, self._runs(pieces, starts))

    def survivors(self, samples: Samples, kept: Kept) -> KeptOfSamples:
        """Put those samples that survive in the order that all have."""
        pieces = kept.pieces
        places, rows, rays = np.zeros((3, total(pieces)), dtype=np.int32)
        starts = []
        for low, begins in samples.starts:
            kept_begins = np.zeros_like(begins)
            fields = Fields(
                reads={
                    "items": items,
                    "places": of_all(samples.places),
                    "starts": of_pieces(begins),
                },
                writes={
                    "kept_starts": of_pieces(kept_begins),
                    "kept_places": of_samples(places),
                    "rows": of_samples(rows),
                    "rays": of_samples(rays),
                },
                work={"marks": lambda piece: _listed(piece) + 1},
                scalars=lambda piece: {
                    "first_ray": piece.first_ray,
                    "first_row": piece.places.start,
                },
                cost=lambda piece: _listed(piece) + RAYS,
            )
            fields.run(self._device, _STAGE, f"{_KERNELS}:group_survivors", filled(pieces))
            starts.append((low, kept_begins))
        return KeptOfSamples(places, rows, rays, self._runs(pieces, starts))

    def _words_free(self) -> tuple[tuple[int, int, int], ...]:
        """Return how often a launch that sorts, and one of survivors, has counts of networks, how
        many words of a sample, and words for both.
        """
        words = (self._device.scratchpad_bytes - _LINES * self._device.line_bytes) // WORD_BYTES
        held = sum(array.size for array in self._shared.values()) + _RAY_WORDS * RAYS
        # Networks that are known come with the samples.
        of_sample = _SAMPLE_WORDS + (not self._fits)
        return (1, of_sample, words - held), (2, _SAMPLE_WORDS, words)

    def _ranges_in(self) -> Iterator[tuple[int, int]]:
        """Yield the first network and the number of networks (-1 is one) that are counted at
        once.
        """
        most = min(
            (words - of_sample * self.most_samples) // (counts * _NETWORK_WORDS) - 2
            for counts, of_sample, words in self._free
        )
        parts = -(-self._count // most)
        bounds = [self._count * part // parts - 1 for part in range(parts + 1)]
        return ((low, high - low) for low, high in pairwise(bounds))

    def _scalars(self, low: int) -> Callable[[Piece], dict[str, object]]:
        return lambda _: {"known": int(not self._fits), "low": low}

    def _numbers(self, points: Float32Array) -> Int32Array:
        """Return the network of each point, -1: none."""
        numbers = np.zeros(len(points), dtype=np.int32)
        arguments = (points, self._shared["box"], self._shared["grid"], numbers)
        self._device.spread(_STAGE, f"{_KERNELS}:cell_numbers", *arguments)
        return gather_rows(self._device, _STAGE, self._table, [numbers])

    def _runs(self, pieces: Sequence[Piece], starts: Sequence[tuple[int, Int32Array]]) -> Runs:
        """Return the runs that the host reads where each network starts."""
        self._device.ledger.count(words_read_by_host=sum(begins.size for _, begins in starts))
        firsts = [piece.first for piece in pieces]
        return [run for low, begins in starts for run in runs_of(begins, firsts, low)]


def _listed(piece: Survivors) -> int:
    """Return how many samples it had before."""
    samples: int = piece.places.stop - piece.places.start
    return samples


def runs_of(starts: Int32Array, firsts: Sequence[int], low: int) -> Iterator[tuple[int, int, int]]:
    """Yield network, first place and number of samples, of networks from `low` on; those without
    a network are left out. Pieces begin at `firsts`.
    """
    for first, row in zip(firsts, starts, strict=True):
        begins, ends = row[:-2], row[1:-1]
        for slot in np.flatnonzero(ends > begins).tolist():
            if low + slot >= 0:
                begin = int(begins[slot])
                yield low + slot, first + begin, int(ends[slot]) - begin


def parts_of(runs: Runs, most: int) -> Iterator[Part]:
    """Yield at most so many samples each of one network, by network, so that weights are loaded
    once.
    """
    for network, some in groupby(sorted(runs), lambda run: run[0]):
        places: list[slice] = []
        room = most
        for _, begin, count in some:
            at, end = begin, begin + count
            while at < end:
                places.append(slice(at, min(at + room, end)))
                room -= places[-1].stop - at
                at = places[-1].stop
                if not room:
                    yield Part(network, tuple(places))
                    places, room = [], most
        if places:
            yield Part(network, tuple(places))
