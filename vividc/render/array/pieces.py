"""The samples of a batch: pieces of a block's, as many as a launch has room for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.render.arrays import Float32Array, Int32Array

SIDE: Final = 8
"""Pixels of a block's side."""
RAYS: Final = SIDE * SIDE
_PLACE_BITS: Final = 10
"""Of a sample in its piece."""
_LAST: Final = (1 << _PLACE_BITS) - 1


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """The rays of a batch as the kernels take them.

    Attributes
    ----------
    directions
        [n, 3] float32, (0, 0, 0) outside the picture.
    entries
        [n] float32 distance at which each enters the box.
    steps
        [n] uint32 first step, and << 16 the one behind the last.
    """

    directions: Float32Array
    entries: Float32Array
    steps: npt.NDArray[np.uint32]


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Samples of a block's rays, in the order in which they are computed.

    Attributes
    ----------
    number
        Among all pieces.
    first_ray
        Of the block: a number in the batch.
    turn
        How many pieces of the block are before it.
    is_last
        No piece of the block is behind it.
    first
        Number of its first sample among those of all pieces.
    items
        [n] int32 as in kernels/render/marching.py.
    """

    number: int
    first_ray: int
    turn: int
    is_last: bool
    first: int
    items: Int32Array

    def __len__(self) -> int:
        return len(self.items)

    @property
    def samples(self) -> slice:
        """Which of all samples are its own."""
        return slice(self.first, self.first + len(self.items))

    @property
    def rays(self) -> slice:
        """Which of the batch's rays are the block's."""
        return slice(self.first_ray, self.first_ray + RAYS)


@dataclass(frozen=True, slots=True, eq=False)
class Survivors(Piece):
    """Those samples of a piece whose colour is computed.

    Attributes
    ----------
    places
        Which of all samples the piece's are.
    span
        The same from the first to the last one that survives.
    weights
        [n] float32, 0 where a colour does not count.
    """

    places: slice
    span: slice
    weights: Float32Array


def total(pieces: Sequence[Piece]) -> int:
    """Return the samples of all pieces."""
    return sum(map(len, pieces))


def pieces_of(blocks: Sequence[Sequence[Int32Array]], most: int) -> Iterator[Piece]:
    """Yield pieces of at most so many samples of blocks, of each its lists of items; a block
    without any has none.
    """
    first = count = 0
    for block, lists in enumerate(blocks):
        cut = [part for items in lists for part in np.array_split(items, -(-len(items) // most))]
        for turn, items in enumerate(cut):
            yield Piece(count, block * RAYS, turn, turn == len(cut) - 1, first, items)
            first, count = first + len(items), count + 1


def survivors_of(
    pieces: Sequence[Piece],
    returned: Sequence[int],
    items: Int32Array,
    weights: Float32Array,
) -> Iterator[Survivors]:
    """Yield the survivors of each piece, which are at the head of its places in the arrays; the
    kernel that lists them returned how many, and the first's and the last's place.
    """
    first = 0
    for piece, word in zip(pieces, returned, strict=True):
        count, low, high = word >> 2 * _PLACE_BITS, word >> _PLACE_BITS & _LAST, word & _LAST
        head = slice(piece.first, piece.first + count)
        span = slice(piece.first + low, piece.first + high + (count > 0))
        yield Survivors(
            *(piece.number, piece.first_ray, piece.turn, piece.is_last, first),
            *(items[head], piece.samples, span, weights[head]),
        )
        first += count
