"""Occupancy as the marching kernel reads it: bricks of 4x4x4 cells, those without a cell left out.

A rank directory over a bit vector (Jacobson 1989): a brick's place is the number of set bits before
its own, of which the directory holds those before each word.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.machine.words import WORD_BITS

BRICK: Final = 4
"""Cells of a brick's side."""
_PLACE_BITS: Final = (11, 11, 10)
_BYTE_BITS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Bricks:
    """A grid of cells, one bit each.

    Attributes
    ----------
    grid
        [6] int32: cells of the three axes, bricks of the three axes.
    coarse
        [words] uint32, a bit for each brick, the lowest first: it has a cell that is set.
    ranks
        [words] int32: set bits before each word of `coarse`.
    cells
        [2 set bricks] uint32: the cells of each set brick, the last axis fastest.
    places
        [set bricks] uint32: x | y << 11 | z << 22 of each; None: an axis has more bricks than bits.
    """

    grid: npt.NDArray[np.int32]
    coarse: npt.NDArray[np.uint32]
    ranks: npt.NDArray[np.int32]
    cells: npt.NDArray[np.uint32]
    places: npt.NDArray[np.uint32] | None

    @property
    def size_bytes(self) -> int:
        """Of the tables that a march needs, together."""
        return self.coarse.nbytes + self.ranks.nbytes + self.cells.nbytes


def pack_bricks(occupied: npt.NDArray[np.bool_]) -> Bricks:
    """Return the bricks of cells [X, Y, Z]."""
    shape = np.array(occupied.shape)
    count = -(-shape // BRICK)
    padded = np.zeros(tuple(count * BRICK), dtype=np.bool_)
    padded[tuple(slice(size) for size in occupied.shape)] = occupied
    x, y, z = count
    blocks = padded.reshape(x, BRICK, y, BRICK, z, BRICK).transpose(0, 2, 4, 1, 3, 5)
    cells = blocks.reshape(-1, BRICK**3)
    is_set: npt.NDArray[np.bool_] = np.any(cells, axis=1)
    coarse = _words(is_set)
    in_word = np.bitwise_count(coarse).astype(np.int64)
    return Bricks(
        grid=np.array([*shape, *count], dtype=np.int32),
        coarse=coarse,
        ranks=(np.cumsum(in_word) - in_word).astype(np.int32),
        cells=_words(cells[is_set].ravel()) if is_set.any() else np.zeros(2, dtype=np.uint32),
        places=_places(is_set.reshape(x, y, z)),
    )


def _places(is_set: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint32] | None:
    """Return the places of set bricks in a word each, if they fit one."""
    if any(size > 1 << bits for size, bits in zip(is_set.shape, _PLACE_BITS, strict=True)):
        return None
    x, y, z = np.argwhere(is_set).T.astype(np.uint32)
    packed: npt.NDArray[np.uint32] = x | (y << np.uint32(11)) | (z << np.uint32(22))
    return packed


def _words(bits: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint32]:
    """Return bits as words, the lowest first."""
    words = -(-len(bits) // WORD_BITS)
    filled = np.zeros(words * WORD_BITS, dtype=np.bool_)
    filled[: len(bits)] = bits
    packed = np.packbits(filled, bitorder="little").reshape(words, WORD_BITS // _BYTE_BITS)
    return packed.view("<u4").astype(np.uint32).ravel()
