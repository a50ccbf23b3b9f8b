"""Samples as streams of records: a kernel runs once a piece, over fields of rays and samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.blocks import BLOCK
from vividc.render.array.device.device import Device
from vividc.render.array.device.gather import gather_rows
from vividc.render.array.device.launch import Launch, Words
from vividc.render.array.pieces import RAYS, Piece, Rays, Survivors, total
from vividc.render.array.steering import COPIED_WORDS, LAUNCH_SAMPLES
from vividc.render.arrays import Float32Array, Int32Array

SomePiece = TypeVar("SomePiece", bound=Piece)
Column: TypeAlias = Callable[[Any], Words]
"""What an array has of a piece: `of_rays` and so on, `items` or `weights`."""
Columns: TypeAlias = Mapping[str, Column | None]
"""By parameter; None: it is not there."""
Features: TypeAlias = npt.NDArray[np.float32 | np.uint32]
"""[n, F] words of four bytes: numbers, or what a field packs into them."""
UInt32Array: TypeAlias = npt.NDArray[np.uint32]

MARCHING: Final = "render/marching"
"""File of the kernels."""
_RAY_WORDS: Final = 4
_ARRAYS: Final = 4
"""Of a kernel that makes blocks."""
_COMPACTION: Final = "compaction"
_ROWS: Final = 2
"""Dimensions of features that are not in blocks."""


def items(piece: Piece) -> Words:
    """Return the items themselves."""
    return piece.items


def weights(piece: Survivors) -> Words:
    """Return the weights of survivors."""
    return piece.weights


def of_rays(array: Words) -> Column:
    """Return a field of the batch's rays."""
    return lambda piece: array[piece.rays]


def of_samples(array: Words) -> Column:
    """Return a field of the samples that the pieces are of."""
    return lambda piece: array[piece.samples]


def of_all(array: Words) -> Column:
    """Return a field of all samples, whether they survive or not."""
    return lambda piece: array[piece.places]


def of_pieces(arrays: Words | Sequence[Words]) -> Column:
    """Return what each piece has one of."""
    return lambda piece: arrays[piece.number]


def of_blocks(array: Words) -> Column:
    """Return a field of the rays [R, ...] that launches of a block hand on to each other: they name
    the same array.
    """
    blocks = list(array.reshape(-1, RAYS, *array.shape[1:]))
    return lambda piece: blocks[piece.first_ray // RAYS]


def filled(pieces: Sequence[SomePiece]) -> list[SomePiece]:
    """Return the pieces that have samples."""
    return [piece for piece in pieces if len(piece)]


@dataclass(frozen=True, slots=True, eq=False)
class Fields:
    """What a kernel takes of a piece, and leaves.

    Attributes
    ----------
    reads, writes
        Fields that are moved in before, and out after it.
    count
        A word in which the kernel leaves how many rows of each of `writes` leave; None: all.
    shared
        Arrays that all launches read.
    holds, carries
        What launches in a row that name the same arrays keep in a scratchpad: what they read, and
        what they hand on to each other.
    work
        Room to work in, and how many words that is.
    scalars
        Other arguments.
    cost
        Of a launch: its samples, and what a launch costs in samples.
    """

    reads: Columns
    writes: Columns = field(default_factory=dict)
    count: str | None = None
    shared: Mapping[str, Words] = field(default_factory=dict)
    holds: Columns = field(default_factory=dict)
    carries: Columns = field(default_factory=dict)
    work: Mapping[str, Callable[[Any], int]] = field(default_factory=dict)
    scalars: Callable[[Any], Mapping[str, object]] = lambda _: {}
    cost: Callable[[Any], int] = lambda piece: len(piece) + LAUNCH_SAMPLES

    def run(self, device: Device, stage: str, kernel: str, pieces: Iterable[Piece]) -> list[int]:
        """Run the kernel once a piece, and return what each run returned."""
        counted = {
            name: self.count for name, column in self.writes.items() if column and self.count
        }
        launches = [
            Launch(
                shapes={name: (1,) for name in set(counted.values())},
                inputs=_of(piece, self.reads),
                outputs=_of(piece, self.writes),
                counted=counted,
                shared={**self.shared, **_of(piece, self.holds)},
                carried=_of(piece, self.carries),
                work={name: (words(piece),) for name, words in self.work.items()},
                scalars=self.scalars(piece),
                cost=self.cost(piece),
            )
            for piece in pieces
        ]
        return device.run(stage, kernel, launches)


def _of(piece: Piece, columns: Columns) -> dict[str, Words]:
    return {name: column(piece) for name, column in columns.items() if column is not None}


@dataclass(frozen=True, slots=True, eq=False)
class Densities:
    """What samples have.

    Attributes
    ----------
    thickness, features
        [n] optical thickness of one step, and [n, F] or blocks of 16 samples [B, F, 16]; both are
        C-contiguous. What features mean is the field's own affair, `Kept.features` gives rows of
        them.
    places
        [n] where each sample's are, counted from its piece's first; None: in the samples' order.
    """

    thickness: Float32Array
    features: Features
    places: Int32Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Colours:
    """r, g, b [n, 3] of each piece's samples, and `places` as of `Densities`."""

    of_pieces: Sequence[Float32Array]
    places: Int32Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Listed:
    """The samples whose density is wanted; jobs make what is asked for of them.

    Attributes
    ----------
    geometry
        The table that kernels/render/marching.py calls so.
    rays
        Of the batch.
    pieces
        Which samples they are.
    """

    device: Device
    geometry: Float32Array
    rays: Rays
    pieces: Sequence[Piece]

    @property
    def of_rays(self) -> dict[str, Column]:
        """Columns of the rays."""
        rays = self.rays
        return {"directions": of_rays(rays.directions), "entries": of_rays(rays.entries)}

    def points(self) -> Float32Array:
        """Return their places [n, 3]."""
        points = np.zeros((total(self.pieces), 3), dtype=np.float32)
        self._locate("ray marching", {"points": of_samples(points)}, {"rays": len})
        return points

    def _locate(
        self, stage: str, made: Columns, work: Mapping[str, Callable[[Piece], int]] | None = None
    ) -> None:
        fields = Fields(
            reads={**self.of_rays, "items": items},
            writes=made,
            shared={"geometry": self.geometry},
            work=work or {},
            scalars=lambda piece: {"first_ray": piece.first_ray},
        )
        fields.run(self.device, stage, f"{MARCHING}:sample_points", filled(self.pieces))


@dataclass(frozen=True, slots=True, eq=False)
class Kept(Listed):
    """The samples whose colour is wanted.

    Attributes
    ----------
    pieces
        Some have no samples.
    computed
        Features of all samples, as of `Densities`.
    lookahead
        Whether some of the samples are left out.
    """

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
        return list(map(len, self.pieces))

    def located(self) -> tuple[Float32Array, Int32Array]:
        """Return their places [n, 3] and rays [n]; those in a row lie near each other."""
        points = np.zeros((total(self.pieces), 3), dtype=np.float32)
        rays = np.zeros(len(points), dtype=np.int32)
        self._locate(_COMPACTION, {"points": of_samples(points), "rays": of_samples(rays)})
        return points, rays

    def features(self) -> Features:
        """Return their features [n, F], as `densities` returned them."""
        computed, count = self.computed, total(self.pieces)
        width = computed.shape[1]
        if not self.lookahead or not width:
            return computed[:count]
        if not is_narrow(computed):
            rows = [piece.numbers for piece in self.pieces]
            return gather_rows(self.device, _COMPACTION, computed, rows)
        kept = np.zeros((count, width), dtype=np.uint32)
        words, out = of_all(computed.view(np.uint32)), of_samples(kept)
        fields = Fields(
            reads={"rows": lambda piece: words(piece).reshape(-1), "items": items},
            writes={"out": lambda piece: out(piece).reshape(-1)},
            scalars=lambda _: {"shift": width.bit_length() - 1},
        )
        fields.run(self.device, _COMPACTION, f"{MARCHING}:keep_rows", filled(self.pieces))
        return kept.view(computed.dtype)

    def in_blocks(
        self, kernel: str, of_rays: UInt32Array, words: int, scalars: Mapping[str, object]
    ) -> UInt32Array:
        """Return what a kernel makes of words [R, 4] of their rays and of blocks of features,
        [B, words, 16] uint32: of each piece as many blocks as it takes, and the last one filled up
        with its last sample. Launches of a piece share its features.

        Parameters
        ----------
        kernel
            Gets `outputs`, [m, F, 16] blocks as words in which samples of a piece are, `first`,
            which of the first block's samples is the piece's first, `of_rays`, [64, 4] of its
            rays, `items`, as in kernels/render/marching.py, the scalars, and `out`.
        """
        computed = self.computed.view(np.uint32)
        ends = accumulate((-(-length // BLOCK) for length in self.lengths), initial=0)
        *_, (_, count) = places = list(pairwise(ends))
        out = np.zeros((count, words, BLOCK), dtype=np.uint32)
        at_once = self._blocks_at_once(computed.shape[1], words)
        launches = []
        for piece, (first, last) in zip(self.pieces, places, strict=True):
            before, behind = piece.places.start, piece.places.stop
            blocks = computed[before // BLOCK : -(-behind // BLOCK)]
            shared = {"outputs": blocks, "of_rays": of_rays[piece.rays]}
            given = {"first": before % BLOCK, **scalars}
            for start in range(first, last, at_once):
                end = min(start + at_once, last)
                some = piece.items[BLOCK * (start - first) : BLOCK * (end - first)]
                made, cost = out[start:end], len(some) + LAUNCH_SAMPLES
                launches.append(
                    Launch({}, {"items": some}, {"out": made}, shared, scalars=given, cost=cost)
                )
        self.device.run(_COMPACTION, kernel, launches)
        return out

    def _blocks_at_once(self, width: int, words: int) -> int:
        """Return how many blocks fit twice beside the features of two pieces."""
        most = max(piece.places.stop - piece.places.start for piece in self.pieces)
        held = width * (most + 2 * BLOCK) + _RAY_WORDS * RAYS
        return max(1, self.device.fitting(BLOCK * (1 + words), 2 * held, _ARRAYS))


def asks_for_numbers(features: Features) -> bool:
    """Whether the survivors' numbers are needed for theirs: DMA gathers their rows."""
    return features.ndim == _ROWS and not is_narrow(features)


def is_narrow(features: Features) -> bool:
    """Whether a kernel copies the rows of the survivors."""
    width: int = features.shape[1]
    return width <= COPIED_WORDS and width & (width - 1) == 0
