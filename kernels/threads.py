"""Kernels whose parallel loop a tile runs as threads, each with loops that its own data end."""

import math

import numpy as np
from numba import prange

import vividc

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
FOUR = np.float32(4.0)
ALPHA_MAX = np.float32(0.99)
ALPHA_MIN = np.float32(1.0 / 255.0)
TRANSMITTANCE_MIN = np.float32(1e-4)


@vividc.kernel(
    "void(float32[::1], float32[::1], float32[::1], float32[::1], float32[::1], float32[::1],"
    " float32[::1], float32[::1], float32[::1], float32[::1], int32, int32, int32, int32, int32)"
)
def gs_blend_rows(
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
    """`gs_blend` with rows of pixels in parallel: a thread is done when its pixel is opaque."""
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


@vividc.kernel(
    "void(float32[:, ::1], float32[:, ::1], float32[:, ::1], uint8[::1], float32[::1], int32,"
    " float32, float32[:, ::1])"
)
def march(origins, directions, spans, occupancy, density, resolution, step, out):
    """Optical depth along rays through a grid of cells, up to opacity: steps in empty cells cost no
    density, and rays are as long as their spans. `out` is depth and transmittance.
    """
    for ray in prange(origins.shape[0]):
        ox, oy, oz = origins[ray, 0], origins[ray, 1], origins[ray, 2]
        dx, dy, dz = directions[ray, 0], directions[ray, 1], directions[ray, 2]
        t = spans[ray, 0]
        far = spans[ray, 1]
        transmittance = ONE
        depth = ZERO
        while t < far:
            x = np.int32(ox + t * dx)
            y = np.int32(oy + t * dy)
            z = np.int32(oz + t * dz)
            cell = x + resolution * (y + resolution * z)
            if occupancy[cell] != 0:
                alpha = density[cell]
                weight = transmittance * alpha
                depth += weight * t
                transmittance -= weight
                if transmittance < TRANSMITTANCE_MIN:
                    break
            t += step
        out[ray, 0] = depth
        out[ray, 1] = transmittance


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1], float32[:, ::1])")
def dense_relu_samples(inputs, weights, bias, out):
    """A layer of an MLP with samples in parallel: they share the weights."""
    for sample in prange(inputs.shape[0]):
        for neuron in range(weights.shape[0]):
            total = bias[neuron]
            for k in range(weights.shape[1]):
                total += weights[neuron, k] * inputs[sample, k]
            out[sample, neuron] = max(total, ZERO)


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def fir_outputs(signal, taps, out):
    """`fir` with outputs in parallel."""
    for i in prange(len(out)):
        total = np.int32(0)
        for k in range(len(taps)):
            total = np.int32(total + taps[k] * signal[i + k])
        out[i] = total


@vividc.kernel("void(float32[::1], int32, float32[:, ::1])")
def frequency_encoding(x, frequencies, out):
    """sin x, cos x, sin 2x, cos 2x, ... by the formulas of the double angle."""
    for i in prange(len(x)):
        s = math.sin(x[i])
        c = math.cos(x[i])
        for level in range(frequencies):
            out[i, 2 * level] = s
            out[i, 2 * level + 1] = c
            twice = TWO * s * c
            c = ONE - TWO * s * s
            s = twice


@vividc.kernel("void(float32[::1], float32[::1], int32, int32[::1])")
def escape_time(real, imaginary, limit, counts):
    """Iterations of z = z^2 + c until z is far away (the Mandelbrot set)."""
    for i in prange(len(real)):
        x = ZERO
        y = ZERO
        count = np.int32(0)
        while count < limit:
            xx = x * x
            yy = y * y
            if xx + yy > FOUR:
                break
            y = TWO * x * y + imaginary[i]
            x = xx - yy + real[i]
            count = np.int32(count + 1)
        counts[i] = count
