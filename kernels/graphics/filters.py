"""Filters of gray pictures: two that keep edges, error diffusion, and resampling."""

import math

import numba
import numpy as np
from numba import prange

import vividc

f32 = np.float32

WHITE = 255
MIDDLE = 128


@vividc.kernel("void(float32[:, ::1], int32, float32, float32, float32[:, ::1])")
def bilateral(image, radius, sigma_space, sigma_tone, out):
    """Mean of the neighbours, by distance in the plane and in brightness (Tomasi 1998)."""
    height, width = image.shape
    space = f32(-0.5) / (sigma_space * sigma_space)
    tone = f32(-0.5) / (sigma_tone * sigma_tone)
    for y in prange(height):
        for x in range(width):
            centre = image[y, x]
            total = f32(0.0)
            weights = f32(0.0)
            for v in range(max(y - radius, 0), min(y + radius + 1, height)):
                for u in range(max(x - radius, 0), min(x + radius + 1, width)):
                    difference = image[v, u] - centre
                    away = f32((v - y) * (v - y) + (u - x) * (u - x))
                    weight = math.exp(away * space + difference * difference * tone)
                    total += weight * image[v, u]
                    weights += weight
            out[y, x] = total / weights


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], int32, float32, float32[:, :, ::1])")
def fit_lines(guide, image, radius, epsilon, lines):
    """First half of the guided filter (He 2010): `image` as a line over `guide` in each window.

    `lines` takes slope and intercept. Windows end at the borders.
    """
    height, width = image.shape
    for y in prange(height):
        for x in range(width):
            count = f32(0.0)
            sum_g = sum_p = sum_gp = sum_gg = f32(0.0)
            for v in range(max(y - radius, 0), min(y + radius + 1, height)):
                for u in range(max(x - radius, 0), min(x + radius + 1, width)):
                    g = guide[v, u]
                    p = image[v, u]
                    count += f32(1.0)
                    sum_g += g
                    sum_p += p
                    sum_gp += g * p
                    sum_gg += g * g
            scale = f32(1.0) / count
            mean_g = sum_g * scale
            mean_p = sum_p * scale
            covariance = sum_gp * scale - mean_g * mean_p
            variance = sum_gg * scale - mean_g * mean_g
            slope = covariance / (variance + epsilon)
            lines[y, x, 0] = slope
            lines[y, x, 1] = mean_p - slope * mean_g


@vividc.kernel("void(float32[:, ::1], float32[:, :, ::1], int32, float32[:, ::1])")
def apply_lines(guide, lines, radius, out):
    """Second half: the mean line of the windows that a pixel is in, at its guide."""
    height, width = guide.shape
    for y in prange(height):
        for x in range(width):
            count = f32(0.0)
            slope = intercept = f32(0.0)
            for v in range(max(y - radius, 0), min(y + radius + 1, height)):
                for u in range(max(x - radius, 0), min(x + radius + 1, width)):
                    count += f32(1.0)
                    slope += lines[v, u, 0]
                    intercept += lines[v, u, 1]
            out[y, x] = (slope * guide[y, x] + intercept) / count


@vividc.kernel("void(int16[:, ::1])")
def floyd_steinberg(image):
    """Gray levels become 0 or 255, in place; errors go to pixels yet to come (Floyd 1976)."""
    height, width = image.shape
    for y in range(height):
        for x in range(width):
            old = image[y, x]
            new = WHITE if old >= MIDDLE else 0
            image[y, x] = new
            error = old - new
            if x + 1 < width:
                image[y, x + 1] += error * 7 // 16
            if y + 1 < height:
                if x > 0:
                    image[y + 1, x - 1] += error * 3 // 16
                image[y + 1, x] += error * 5 // 16
                if x + 1 < width:
                    image[y + 1, x + 1] += error // 16


@numba.njit
def cubic(t):
    """Weight of a sample at distance t (Keys 1981)."""
    t = abs(t)
    if t < f32(1.0):
        return (f32(1.5) * t - f32(2.5)) * t * t + f32(1.0)
    if t < f32(2.0):
        return ((f32(-0.5) * t + f32(2.5)) * t - f32(4.0)) * t + f32(2.0)
    return f32(0.0)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def bicubic(image, out):
    """The picture in another size, by cubic interpolation; borders are repeated."""
    height, width = image.shape
    scale_y = f32(height) / f32(out.shape[0])
    scale_x = f32(width) / f32(out.shape[1])
    for y in prange(out.shape[0]):
        v = (f32(y) + f32(0.5)) * scale_y - f32(0.5)
        top = np.int32(np.floor(v)) - 1
        for x in range(out.shape[1]):
            u = (f32(x) + f32(0.5)) * scale_x - f32(0.5)
            left = np.int32(np.floor(u)) - 1
            total = f32(0.0)
            for j in range(4):
                row = min(max(top + j, 0), height - 1)
                line = f32(0.0)
                for i in range(4):
                    column = min(max(left + i, 0), width - 1)
                    line += cubic(u - f32(left + i)) * image[row, column]
                total += cubic(v - f32(top + j)) * line
            out[y, x] = min(max(total, f32(0.0)), f32(1.0))
