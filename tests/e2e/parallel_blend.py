"""`kernels/gs_blend.py` with its loop over rows as the parallel one."""

import math

import numpy as np
from numba import prange

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
ALPHA_MAX = np.float32(0.99)
ALPHA_MIN = np.float32(1.0 / 255.0)
TRANSMITTANCE_MIN = np.float32(1e-4)


@vividc.kernel(
    "void(float32[::1], float32[::1], float32[::1], float32[::1], float32[::1], float32[::1],"
    " float32[::1], float32[::1], float32[::1], float32[::1], int32, int32, int32, int32, int32)"
)
def blend_rows(  # noqa: PLR0913, PLR0917 - a kernel's parameters
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
    for row in prange(height):
        py = np.float32(np.int32(y0 + row))
        for col in range(width):
            px = np.float32(np.int32(x0 + col))
            transmittance = ONE
            r = ZERO
            g = ZERO
            b = ZERO
            for k in range(n):
                dx = mean_x[k] - px
                dy = mean_y[k] - py
                power = -HALF * (conic_a[k] * dx * dx + conic_c[k] * dy * dy) - conic_b[k] * dx * dy
                if power > ZERO:
                    continue
                alpha = min(ALPHA_MAX, opacity[k] * math.exp(power))
                if alpha < ALPHA_MIN:
                    continue
                left = transmittance * (ONE - alpha)
                if left < TRANSMITTANCE_MIN:
                    break
                weight = alpha * transmittance
                r += red[k] * weight
                g += green[k] * weight
                b += blue[k] * weight
                transmittance = left
            pixel = 4 * (row * width + col)
            out[pixel] = r
            out[pixel + 1] = g
            out[pixel + 2] = b
            out[pixel + 3] = transmittance
