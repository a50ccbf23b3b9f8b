"""A kernel with the parameters of the blend and less to map: sums over a block's list."""

import numpy as np

import vividc


@vividc.kernel(
    "void(float32[::1], float32[::1], float32[::1], float32[::1], float32[::1], float32[::1],"
    " float32[::1], float32[::1], float32[::1], float32[::1], int32, int32, int32, int32, int32)"
)
def sum_blend(  # noqa: PLR0913, PLR0917 - a kernel's parameters
    mean_x,
    mean_y,
    conic_a,
    conic_b,
    conic_c,
    opacity,
    red,
    green,
    blue,
    out,
    x0,
    y0,
    width,
    height,
    n,
):
    r = np.float32(0)
    g = np.float32(0)
    b = np.float32(0)
    for k in range(n):
        r += mean_x[k] + conic_a[k] + opacity[k]
        g += mean_y[k] + conic_b[k] + red[k]
        b += conic_c[k] + green[k] + blue[k]
    for pixel in range(width * height):
        out[4 * pixel] = r
        out[4 * pixel + 1] = g + np.float32(np.int32(x0 + 100 * y0))
        out[4 * pixel + 2] = b
        out[4 * pixel + 3] = np.float32(np.int32(pixel))
