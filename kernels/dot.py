"""Dot product, returned as a scalar (BLAS level 1)."""

import numpy as np

import vividc


@vividc.kernel("float32(float32[::1], float32[::1], int32)")
def dot(x, y, n):
    total = np.float32(0.0)
    for i in range(n):
        total += x[i] * y[i]
    return total
