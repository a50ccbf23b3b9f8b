"""Kernels of the table of precisions: blending with a row's pixels in parallel, an exponential by
itself, and chains of fused multiply-adds in three formats.
"""

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
def gs_blend_columns(
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
    """`gs_blend` with the pixels of a row in parallel: they share what depends on the row."""
    for row in range(height):
        py = np.float32(np.int32(y0 + row))
        for col in prange(width):
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


@vividc.kernel("void(float32[::1], float32[::1])")
def exponentials(x, y):
    """exp of each element."""
    for i in prange(len(x)):
        y[i] = math.exp(x[i])


def chains(cast, name):
    """Sixteen chains of `m` FMAs from each element on, in the format that `cast` makes."""

    @vividc.kernel("void(float32[::1], float32[::1], int32)", name=name)
    def kernel(x, out, m):
        for i in prange(len(out)):
            a = cast(np.float32(0.5))
            b = cast(np.float32(0.25))
            c0 = cast(x[i + 0])
            c1 = cast(x[i + 1])
            c2 = cast(x[i + 2])
            c3 = cast(x[i + 3])
            c4 = cast(x[i + 4])
            c5 = cast(x[i + 5])
            c6 = cast(x[i + 6])
            c7 = cast(x[i + 7])
            c8 = cast(x[i + 8])
            c9 = cast(x[i + 9])
            c10 = cast(x[i + 10])
            c11 = cast(x[i + 11])
            c12 = cast(x[i + 12])
            c13 = cast(x[i + 13])
            c14 = cast(x[i + 14])
            c15 = cast(x[i + 15])
            for _ in range(m):
                c0 = vividc.lang.fma(c0, a, b)
                c1 = vividc.lang.fma(c1, a, b)
                c2 = vividc.lang.fma(c2, a, b)
                c3 = vividc.lang.fma(c3, a, b)
                c4 = vividc.lang.fma(c4, a, b)
                c5 = vividc.lang.fma(c5, a, b)
                c6 = vividc.lang.fma(c6, a, b)
                c7 = vividc.lang.fma(c7, a, b)
                c8 = vividc.lang.fma(c8, a, b)
                c9 = vividc.lang.fma(c9, a, b)
                c10 = vividc.lang.fma(c10, a, b)
                c11 = vividc.lang.fma(c11, a, b)
                c12 = vividc.lang.fma(c12, a, b)
                c13 = vividc.lang.fma(c13, a, b)
                c14 = vividc.lang.fma(c14, a, b)
                c15 = vividc.lang.fma(c15, a, b)
            total = (((c0 + c1) + (c2 + c3)) + ((c4 + c5) + (c6 + c7))) + (
                ((c8 + c9) + (c10 + c11)) + ((c12 + c13) + (c14 + c15))
            )
            out[i] = np.float32(total)

    return kernel


fma_fp32 = chains(np.float32, "fma_fp32")
fma_fp16 = chains(vividc.lang.fp16, "fma_fp16")
fma_fp8 = chains(vividc.lang.fp8, "fma_fp8")
fma_e5m2 = chains(vividc.lang.e5m2, "fma_e5m2")
