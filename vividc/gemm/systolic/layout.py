"""Where the operands of a systolic product lie: no two accesses of a cycle meet in a bank.

Element x of stream s is word 4 x + s: A, B, C and the table never share a bank. In one cycle the
loads of A and the stores of C are of different rows, the loads of B of different columns; x counts
these fastest, so that they lie in different banks whatever their other index is. Loads from one row
of the table come in different cycles, and the table's rows are as long as its columns are many.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

STREAMS = 4
"""Words between neighbours of a stream: a power of two above the number of streams."""


class Stream(IntEnum):
    """The matrices, by their place in each group of words, and the table of places."""

    A = 0
    B = 1
    C = 2
    TABLE = 3


TABLE_ROW = 4
"""Elements of a row of the table: the places of the blocks of A, B and C of one iteration."""

GROUP_BYTES = 4 * STREAMS
"""Bytes from an element of a stream to the next."""


@dataclass(frozen=True, slots=True)
class BlockLayout:
    """Blocks of `rows` x `cols` with inner dimension `depth`, in `words` words of scratchpad.

    A block of A and a block of C have the same form, column by column, so that the next product
    reads what one product wrote. A block of B holds its bias behind its last row.
    """

    rows: int
    cols: int
    depth: int
    words: int

    @property
    def room(self) -> int:
        """Elements of a stream."""
        return self.words // STREAMS

    @property
    def band(self) -> int:
        """Elements of a block of B with its bias."""
        return (self.depth + 1) * self.cols

    def blocks(self, columns: int) -> int:
        """Blocks of rows of a matrix of `columns` columns that fit."""
        return self.room // (self.rows * columns)

    @property
    def iterations(self) -> int:
        """Rows of the table that fit."""
        return self.room // TABLE_ROW

    def a(self, i: int, k: int) -> int:
        """Element of row `i`, inner index `k`, of a block."""
        return k * self.rows + i

    def b(self, j: int, k: int) -> int:
        """Element of column `j`, inner index `k`, of a block; k = `depth`: the bias."""
        return k * self.cols + j

    def c(self, i: int, j: int) -> int:
        """Element of row `i`, column `j`, of a block."""
        return j * self.rows + i


def write_blocks(stream: NDArray[np.float32], matrix: NDArray[np.float32], rows: int) -> None:
    """Lay out `matrix`, float32 [blocks * rows, columns], in a stream, float32 [room]."""
    blocks = matrix.shape[0] // rows
    stream[: matrix.size] = matrix.reshape(blocks, rows, -1).transpose(0, 2, 1).ravel()


def read_blocks(
    stream: NDArray[np.float32], blocks: int, columns: int, rows: int
) -> NDArray[np.float32]:
    """The matrix that `write_blocks` lays out: float32 [blocks * rows, columns]."""
    shaped = stream[: blocks * rows * columns].reshape(blocks, columns, rows)
    return np.ascontiguousarray(shaped.transpose(0, 2, 1).reshape(blocks * rows, columns))
