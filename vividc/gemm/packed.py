"""Operands of 16 and 8 bits: two or four consecutive inner indices to a word, lane 0 first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vividc.formats import FORMATS, round_array
from vividc.gemm.systolic import Precision

Matrix = NDArray[np.float32]


def packed(matrix: Matrix, precision: Precision) -> Matrix:
    """A matrix rounded to a format, its rows filled with zeros to whole words.

    Parameters
    ----------
    matrix
        float32 [rows, depth].

    Returns
    -------
    Matrix
        The words, as float32 [rows, words]: bits, not numbers, unless the precision is f32.
    """
    if precision == "f32":
        return matrix
    fmt = FORMATS[precision]
    width = -(-matrix.shape[1] // fmt.lanes) * fmt.lanes
    codes = np.zeros((matrix.shape[0], width), np.dtype(fmt.dtype).newbyteorder("<"))
    codes[:, : matrix.shape[1]] = round_array(fmt, matrix)
    return codes.view("<u4").astype(np.uint32).view(np.float32)
