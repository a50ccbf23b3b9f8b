"""Samples as streams of records: a kernel runs once a piece, over fields of rays and samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise
from math import prod
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.blocks import BLOCK
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch, Words
from vividc.render.array.pieces import RAYS, Piece, Rays, Survivors, total
from vividc.render.array.steering import LAUNCH_SAMPLES
from vividc.render.arrays import Float32Array

SomePiece = TypeVar("SomePiece", bound=Piece)
Column: TypeAlias = Callable[[Any], Words]
"""What an array has of a piece: `of_rays` and so on, `items` or `weights`."""
Columns: TypeAlias = Mapping[str, Column | None]
"""By parameter; None: it is not there."""
UInt32Array: TypeAlias = npt.NDArray[np.uint32]

MARCHING: Final = "render/marching"
"""File of the kernels."""
_ARRAYS: Final = 4
"""Of a kernel that makes blocks."""
_COMPACTION: Final = "compaction"


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


def blocks_of_samples(array: Words) -> Column:
    """Return the blocks of 16 samples that the pieces' are in, from `place_in_block` on."""
    return lambda piece: array[piece.first // BLOCK : -(-piece.samples.stop // BLOCK)]


def place_in_block(piece: Piece) -> dict[str, int]:
    """Return the scalar that says which of its first block's samples is a piece's first."""
    return {"first": piece.first % BLOCK}


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
    count
        A word in which the kernel leaves how many rows of each of `writes` leave; None: all.
    """

    reads: Columns
    writes: Columns = field(default_factory=dict)
    shared: Mapping[str, Words] = field(default_factory=dict)
    holds: Columns = field(default_factory=dict)
    carries: Columns = field(default_factory=dict)
    work: Mapping[str, Callable[[Any], int]] = field(default_factory=dict)
    scalars: Callable[[Any], Mapping[str, object]] = lambda _: {}
    cost: Callable[[Any], int] = lambda piece: len(piece) + LAUNCH_SAMPLES
    count: str | None = None

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
class Results:
    """What a field has of samples, and the kernel that makes light or colours of it.

    Attributes
    ----------
    kernel
        Of kernels/render/marching.py.
    reads, scalars
        As of `Fields`, beside what the kernels take of all fields.
    """

    kernel: str
    reads: Columns
    scalars: Callable[[Any], Mapping[str, object]] = lambda _: {}

    def run(self, device: Device, stage: str, pieces: Iterable[Piece], fields: Fields) -> list[int]:
        """Run the kernel once a piece, with all other fields."""
        every = replace(
            fields,
            reads={**self.reads, **fields.reads},
            scalars=lambda piece: {**self.scalars(piece), **fields.scalars(piece)},
        )
        return every.run(device, stage, f"{MARCHING}:{self.kernel}", pieces)


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

    def points(self, stage: str = "ray marching") -> Float32Array:
        """Return their places [n, 3]."""
        shared = {"geometry": self.geometry}
        return self._made(stage, "sample_points", self.of_rays, shared)

    def _made(
        self, stage: str, kernel: str, of_rays: Columns, shared: Mapping[str, Words]
    ) -> Float32Array:
        """Return what a kernel makes of each sample's ray and step, [n, 3]."""
        out = np.zeros((total(self.pieces), 3), dtype=np.float32)
        fields = Fields({**of_rays, "items": items}, {"out": of_samples(out)}, shared)
        fields.run(self.device, stage, f"{MARCHING}:{kernel}", filled(self.pieces))
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Kept(Listed):
    """The samples whose colour is wanted.

    Attributes
    ----------
    pieces
        Some have no samples.
    """

    pieces: Sequence[Survivors]

    @property
    def directions(self) -> Float32Array:
        """Unit directions [R, 3] of all rays, (0, 0, 0) outside the picture."""
        return self.rays.directions

    @property
    def blocks(self) -> list[slice]:
        """Which blocks each piece's samples fill, those of all pieces one after the other."""
        ends = accumulate((-(-len(piece) // BLOCK) for piece in self.pieces), initial=0)
        return [slice(first, last) for first, last in pairwise(ends)]

    def located(self) -> tuple[Float32Array, Float32Array]:
        """Return their places and their rays' directions [n, 3]; those in a row lie near each
        other.
        """
        seen = {"directions": of_rays(self.directions)}
        directions = self._made(_COMPACTION, "sample_directions", seen, {})
        return self.points(_COMPACTION), directions

    def fill_blocks(
        self,
        kernel: str,
        outputs: Words,
        of_rays: Words,
        out: Words,
        scalars: Mapping[str, object],
    ) -> None:
        """Fill the pieces' `blocks` in `out`, [B, words, 16], with what a kernel makes of words of
        their rays and of a network's outputs, the last block of each with its last sample. Launches
        of a piece share its outputs.

        Parameters
        ----------
        kernel
            Gets `outputs`, the blocks from the piece's first survivor to its last one, `first`,
            where the piece begins, counted from their first sample, `of_rays`, [64, ...] of its
            rays, `items`, as in kernels/render/marching.py, the scalars, and `out`.
        outputs
            Of all samples, [B, outputs, 16].
        of_rays
            Of all rays, [R, ...].
        """
        at_once = self._blocks_at_once(*(prod(one.shape[1:]) for one in (outputs, of_rays, out)))
        launches = []
        for piece, blocks in zip(self.pieces, self.blocks, strict=True):
            begin, end = piece.span.start // BLOCK, -(-piece.span.stop // BLOCK)
            shared = {"outputs": outputs[begin:end], "of_rays": of_rays[piece.rays]}
            given = {"first": piece.places.start - BLOCK * begin, **scalars}
            for start in range(blocks.start, blocks.stop, at_once):
                end = min(start + at_once, blocks.stop)
                first = BLOCK * (start - blocks.start)
                listed = {"items": piece.items[first : first + BLOCK * (end - start)]}
                made, cost = {"out": out[start:end]}, len(listed["items"]) + LAUNCH_SAMPLES
                launches.append(
                    Launch(inputs=listed, outputs=made, shared=shared, scalars=given, cost=cost)
                )
        self.device.run(_COMPACTION, kernel, launches)

    def _blocks_at_once(self, outputs: int, of_ray: int, made: int) -> int:
        """Return how many blocks fit twice beside the outputs of two pieces, or of one, each of so
        many words of a block of outputs, of a ray, and of a block that is made.
        """
        most = max(piece.span.stop - piece.span.start for piece in self.pieces)
        held = outputs // BLOCK * (most + 2 * BLOCK) + of_ray * RAYS
        fitting = (self.device.fitting(BLOCK + made, n * held, _ARRAYS) for n in (2, 1))
        return max(1, next(filter(None, fitting), 1))
