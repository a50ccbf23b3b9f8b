"""Where the operands of a systolic product lie in the scratchpad: no two accesses of a cycle meet in
a bank.

Element x of stream s is word 4 x + s: A, B and C never share a bank. In one cycle the loads of A and
the stores of C are of different rows, the loads of B of different columns; x counts these fastest,
so that they lie in different banks whatever their other index is.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

STREAMS = 4
"""Words between neighbours of a stream: a power of two above the number of streams."""


class Stream(IntEnum):
    """The matrices, by their place in each group of words."""

    A = 0
    B = 1
    C = 2


@dataclass(frozen=True, slots=True)
class BlockLayout:
    """Blocks of `rows` rows of matrices with few columns, in `words` words of scratchpad.

    A block of A with inner dimension `depth` and a block of C have the same form,
    column by column, so that the next product reads what one product wrote. Blocks are a power of two
    of elements apart: a load/store unit shifts the block's number. `a_width` and `c_width` are the
    columns of A and C as they lie in the scratchpad: at least `depth`, and at least `cols`.
    """

    rows: int
    cols: int
    depth: int
    a_width: int
    c_width: int
    words: int

    @property
    def stride(self) -> int:
        """Elements of A from block to block."""
        return stride_of(self.rows, self.a_width)

    @property
    def result_stride(self) -> int:
        """Elements of C from block to block."""
        return stride_of(self.rows, self.c_width)

    @property
    def room(self) -> int:
        """Elements of a stream."""
        return self.words // STREAMS

    @property
    def blocks(self) -> int:
        """Blocks that fit at once; 0: not one."""
        if self.depth * self.cols > self.room:
            return 0
        return self.room // max(self.stride, self.result_stride)

    def a(self, i: int, k: int) -> int:
        """Element of row `i`, inner index `k`, of block 0."""
        return k * self.rows + i

    def b(self, j: int, k: int) -> int:
        """Element of column `j`, inner index `k`."""
        return k * self.cols + j

    def c(self, i: int, j: int) -> int:
        """Element of row `i`, column `j`, of block 0."""
        return j * self.rows + i


def stride_of(rows: int, columns: int) -> int:
    """Elements from block to block of a matrix of `columns` columns, in blocks of `rows` rows."""
    return 1 << (columns * rows - 1).bit_length()


def write_blocks(stream: NDArray[np.float32], matrix: NDArray[np.float32], rows: int) -> None:
    """Lay out `matrix`, float32 [blocks * rows, columns], in a stream, float32 [room]."""
    blocks, columns = matrix.shape[0] // rows, matrix.shape[1]
    stride = stride_of(rows, columns)
    shaped = matrix.reshape(blocks, rows, columns).transpose(0, 2, 1).reshape(blocks, -1)
    for number, block in enumerate(shaped):
        stream[number * stride : number * stride + columns * rows] = block


def read_blocks(
    stream: NDArray[np.float32], blocks: int, columns: int, rows: int
) -> NDArray[np.float32]:
    """The matrix that `write_blocks` lays out: float32 [blocks * rows, columns]."""
    stride = stride_of(rows, columns)
    starts = (number * stride for number in range(blocks))
    found = [stream[at : at + columns * rows].reshape(columns, rows).T for at in starts]
    return np.ascontiguousarray(np.concatenate(found))
