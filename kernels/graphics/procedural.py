"""Pictures from formulas: Perlin noise, and the Mandelbrot set in smooth colours."""

import math

import numba
import numpy as np
from numba import prange

import vividc

f32 = np.float32

ESCAPED = f32(256.0)


@numba.njit
def fade(t):
    return t * t * t * (t * (t * f32(6.0) - f32(15.0)) + f32(10.0))


@numba.njit
def lerp(t, a, b):
    return a + t * (b - a)


@numba.njit
def gradient(code, x, y):
    """(x, y) by one of eight directions."""
    u = x if code & 4 else y
    v = y if code & 4 else x
    if code & 1:
        u = -u
    if code & 2:
        v = -v
    return u + f32(0.5) * v


@numba.njit
def perlin(x, y, permutation):
    """Gradient noise (Perlin 2002) of a place; `permutation` has its 256 entries twice."""
    left = np.floor(x)
    top = np.floor(y)
    i = np.int32(left) & 255
    j = np.int32(top) & 255
    x -= left
    y -= top
    u = fade(x)
    v = fade(y)
    a = permutation[i] + j
    b = permutation[i + 1] + j
    upper = lerp(
        u,
        gradient(permutation[a], x, y),
        gradient(permutation[b], x - f32(1.0), y),
    )
    lower = lerp(
        u,
        gradient(permutation[a + 1], x, y - f32(1.0)),
        gradient(permutation[b + 1], x - f32(1.0), y - f32(1.0)),
    )
    return lerp(v, upper, lower)


@numba.njit
def octaves_of_noise(x, y, permutation, octaves):
    """Sums of noise of doubled frequency and half the height."""
    total = f32(0.0)
    height = f32(1.0)
    for _ in range(octaves):
        total += height * perlin(x, y, permutation)
        x *= f32(2.0)
        y *= f32(2.0)
        height *= f32(0.5)
    return total


@vividc.kernel("void(int32[::1], float32, int32, float32[:, ::1])")
def fractal_noise(permutation, cell, octaves, image):
    """Noise with `cell` pixels between the gradients of the first octave."""
    step = f32(1.0) / cell
    for y in prange(image.shape[0]):
        for x in range(image.shape[1]):
            u = f32(x) * step
            v = f32(y) * step
            image[y, x] = octaves_of_noise(u, v, permutation, octaves)


@numba.njit
def escape_time(real, imaginary, most):
    """Iterations until z leaves a large circle, with a fraction; below 0 where it stays."""
    x = f32(0.0)
    y = f32(0.0)
    for n in range(most):
        xx = x * x
        yy = y * y
        if xx + yy > ESCAPED:
            return f32(n) + f32(1.0) - math.log2(f32(0.5) * math.log2(xx + yy))
        y = f32(2.0) * x * y + imaginary
        x = xx - yy + real
    return f32(-1.0)


@vividc.kernel(
    "void(float32, float32, float32, int32, float32[:, ::1], float32, float32[:, :, ::1])"
)
def mandelbrot_smooth(real, imaginary, view, most, palette, cycle, image):
    """The set around a place; colours follow the fraction of an iteration, without bands.

    `view` is the width of the picture in the plane; the palette, whose length is a power of two,
    comes round every `cycle` iterations.
    """
    height, width, _ = image.shape
    colours = palette.shape[0]
    step = view / f32(width)
    for y in prange(height):
        for x in range(width):
            cx = real + (f32(x) - f32(0.5) * f32(width)) * step
            cy = imaginary + (f32(y) - f32(0.5) * f32(height)) * step
            n = escape_time(cx, cy, most)
            if n < f32(0.0):
                for k in range(3):
                    image[y, x, k] = f32(0.0)
                continue
            place = n / cycle * f32(colours)
            first = np.int32(place)
            share = place - f32(first)
            for k in range(3):
                a = palette[first & (colours - 1), k]
                b = palette[(first + 1) & (colours - 1), k]
                image[y, x, k] = lerp(share, a, b)
