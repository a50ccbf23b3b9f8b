"""The samples whose colour is computed: what a field asks for of them is made by jobs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from vividc import LoopOptions
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launch import Launch
from vividc.render.array.device.launches import run_launches
from vividc.render.array.models.field import Features, UInt32Array
from vividc.render.array.network.networks import SAMPLES
from vividc.render.array.pieces import RAYS, Piece, Rays, Survivors, total
from vividc.render.arrays import Float32Array, Int32Array

KERNELS = "render/marching"
LAUNCH_COST = 40
"""Of a launch of the kernels behind the marching one, in samples."""
_NARROW_WORDS = 4
"""Rows that a kernel copies are as wide at most: DMA reads each row it gathers in granules."""
_RAY_WORDS = 4
_ARRAYS = 4
"""Of a kernel that makes blocks."""
_STAGE = "compaction"


@dataclass(frozen=True, slots=True, eq=False)
class ListedSamples:
    """As `field.Listed` says."""

    device: Device
    ledger: Ledger
    geometry: Float32Array
    rays: Rays
    pieces: Sequence[Piece]

    def points(self) -> Float32Array:
        """Return their places [n, 3]."""
        given = (self.device, self.ledger, "ray marching", self.geometry, self.rays, self.pieces)
        return points_of(*given, with_rays=False)[0]


@dataclass(frozen=True, slots=True, eq=False)
class KeptSamples:
    """As `field.Kept` says.

    Attributes
    ----------
    geometry
        The kernels' table.
    rays
        Of the batch.
    pieces
        Some have no samples.
    computed
        [m, F] features of all samples.
    lookahead
        Whether some of the samples are left out.
    """

    device: Device
    ledger: Ledger
    geometry: Float32Array
    rays: Rays
    pieces: Sequence[Survivors]
    computed: Features
    lookahead: bool

    @property
    def directions(self) -> Float32Array:
        """Unit directions [R, 3] of all rays, (0, 0, 0) outside the picture."""
        return self.rays.directions

    @property
    def lengths(self) -> list[int]:
        """How many samples each piece has."""
        return [len(piece.items) for piece in self.pieces]

    def points(self) -> tuple[Float32Array, Int32Array]:
        """Return their places [n, 3] and rays [n]."""
        given = (self.device, self.ledger, _STAGE, self.geometry, self.rays, self.pieces)
        return points_of(*given, with_rays=True)

    def features(self) -> Features:
        """Return their features [n, F]."""
        computed = self.computed
        width = computed.shape[1]
        if not self.lookahead or not width:
            return computed[: total(self.pieces)]
        if not is_narrow(computed):
            rows = [piece.numbers for piece in self.pieces]
            return gather_rows(self.device, self.ledger, _STAGE, computed, rows)
        words = computed.view(np.uint32)
        kept = np.zeros((total(self.pieces), width), dtype=np.uint32)
        launches = [
            Launch(
                inputs={"rows": words[piece.places].reshape(-1), "items": piece.items},
                outputs={"out": kept[piece.samples].reshape(-1)},
                scalars={"shift": width.bit_length() - 1},
                cost=len(piece.items) + LAUNCH_COST,
            )
            for piece in self.pieces
            if len(piece.items)
        ]
        run_kernel(self.device, self.ledger, _STAGE, "keep_rows", launches)
        return kept.view(computed.dtype)

    def in_blocks(self, kernel: str, of_rays: UInt32Array, words: int) -> UInt32Array:
        """As `field.Kept` says; launches of a piece share its rows."""
        rows = self.computed.view(np.uint32)
        *_, (_, count) = places = list(self._places())
        out = np.zeros((count, words, SAMPLES), dtype=np.uint32)
        at_once = self._blocks_at_once(rows.shape[1], words)
        launches = []
        for piece, (first, last) in zip(self.pieces, places, strict=True):
            shared = {"rows": rows[piece.places], "of_rays": of_rays[piece.rays]}
            for start in range(first, last, at_once):
                end = min(start + at_once, last)
                items = piece.items[SAMPLES * (start - first) : SAMPLES * (end - first)]
                launches.append(
                    Launch(
                        inputs={"items": items},
                        outputs={"out": out[start:end]},
                        shared=shared,
                        cost=len(items) + LAUNCH_COST,
                    )
                )
        run_launches(self.device, self.ledger, _STAGE, kernel, launches)
        return out

    def _blocks_at_once(self, width: int, words: int) -> int:
        """Return how many blocks fit twice beside the rows of two pieces."""
        most = max(len(range(*piece.places.indices(len(self.computed)))) for piece in self.pieces)
        held = WORD_BYTES * (width * most + _RAY_WORDS * RAYS)
        own = SAMPLES * WORD_BYTES * (1 + words)
        lines = 2 * _ARRAYS * self.device.line_bytes
        return max(1, (self.device.scratchpad_bytes - 2 * held - lines) // (2 * own))

    def _places(self) -> Iterator[tuple[int, int]]:
        """Yield the first block of each piece, and the one behind its last."""
        ends = accumulate((-(-length // SAMPLES) for length in self.lengths), initial=0)
        return pairwise(ends)


def is_narrow(features: Features) -> bool:
    """Whether a kernel copies the rows of the survivors."""
    width: int = features.shape[1]
    return width <= _NARROW_WORDS and width & (width - 1) == 0


def points_of(
    device: Device,
    ledger: Ledger,
    stage: str,
    geometry: Float32Array,
    rays: Rays,
    pieces: Sequence[Piece],
    *,
    with_rays: bool,
) -> tuple[Float32Array, Int32Array]:
    """Return the place [n, 3] of each sample, and its ray [n], if it is asked for."""
    points = np.zeros((total(pieces), 3), dtype=np.float32)
    of_rays = np.zeros(len(points), dtype=np.int32)
    launches = [
        Launch(
            shapes={} if with_rays else {"rays": (len(piece.items),)},
            inputs={
                "directions": rays.directions[piece.rays],
                "entries": rays.entries[piece.rays],
                "items": piece.items,
            },
            outputs={
                "points": points[piece.samples],
                **({"rays": of_rays[piece.samples]} if with_rays else {}),
            },
            shared={"geometry": geometry},
            scalars={"first_ray": piece.first_ray},
            cost=len(piece.items) + LAUNCH_COST,
        )
        for piece in pieces
        if len(piece.items)
    ]
    run_kernel(device, ledger, stage, "sample_points", launches)
    return points, of_rays


def run_kernel(
    device: Device, ledger: Ledger, stage: str, kernel: str, launches: Sequence[Launch]
) -> list[int]:
    """Run launches of a marching kernel, and count what the host reads of them: a word each."""
    name = f"{KERNELS}:{kernel}"
    options = {"loops": LoopOptions(auto=False)}
    returned = run_launches(device, ledger, stage, name, launches, **options)
    ledger.count(words_read_by_host=len(launches))
    return returned
