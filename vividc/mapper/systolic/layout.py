"""Where the operands of a systolic product lie in the scratchpad: no two accesses of a cycle meet in
a bank.

Element x of stream s is word 4 x + s: A, B and C never share a bank. In one cycle the loads of A
come from different rows, those of B and the stores of C from different columns; x counts rows
(columns) fastest, so that they lie in different banks whatever their other index is.
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
    """Blocks of `rows` x `cols` with inner dimension `depth` in `words` words of scratchpad.

    The blocks of A are `stride` elements apart, a power of two: the load/store unit shifts the
    block's number.
    """

    rows: int
    cols: int
    depth: int
    words: int

    @property
    def stride(self) -> int:
        """Elements of stream A from block to block."""
        return 1 << (self.depth * self.rows - 1).bit_length()

    @property
    def result_stride(self) -> int:
        """Elements of stream C from block to block."""
        return 1 << (self.rows * self.cols - 1).bit_length()

    @property
    def blocks(self) -> int:
        """Blocks that fit at once; 0: not one."""
        room = self.words // STREAMS
        if self.depth * self.cols > room:
            return 0
        return room // max(self.stride, self.result_stride)

    def a(self, i: int, k: int) -> int:
        """Element of row `i`, inner index `k`, of block 0."""
        return k * self.rows + i

    def b(self, j: int, k: int) -> int:
        """Element of column `j`, inner index `k`."""
        return k * self.cols + j

    def c(self, i: int, j: int) -> int:
        """Element of row `i`, column `j`, of block 0."""
        return i * self.cols + j

    def pack(self, a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
        """The scratchpad's words.

        Parameters
        ----------
        a
            float32 [blocks * rows, depth].
        b
            float32 [depth, cols].
        """
        words = np.zeros((self.words // STREAMS, STREAMS), np.float32)
        blocks = a.shape[0] // self.rows
        shaped = a.reshape(blocks, self.rows, self.depth).transpose(0, 2, 1).reshape(blocks, -1)
        stream = words[: blocks * self.stride, Stream.A].reshape(blocks, self.stride)
        stream[:, : shaped.shape[1]] = shaped
        words[: blocks * self.stride, Stream.A] = stream.ravel()
        words[: b.size, Stream.B] = b.ravel()
        return words.ravel()

    def unpack(self, words: NDArray[np.float32], blocks: int) -> NDArray[np.float32]:
        """C of `blocks` blocks: float32 [blocks * rows, cols]."""
        stream = words.reshape(-1, STREAMS)[: blocks * self.result_stride, Stream.C]
        found = stream.reshape(blocks, -1)[:, : self.rows * self.cols]
        return np.ascontiguousarray(found.reshape(blocks * self.rows, self.cols))
