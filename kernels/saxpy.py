"""y += a * x (BLAS level 1)."""

import vividc


@vividc.kernel("void(float32, float32[::1], float32[::1], int32)")
def saxpy(a, x, y, n):
    for i in range(n):
        y[i] += a * x[i]
