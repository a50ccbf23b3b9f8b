"""Filters and a renderer: whole kernels that are not PolyBench's."""

import math

import numpy as np

import vividc

V, M = "float32[::1]", "float32[:, ::1]"
HALF, ONE, TWO, FAR = np.float32(0.5), np.float32(1.0), np.float32(2.0), np.float32(6.0)


@vividc.kernel(f"void(float32, {M}, {M}, {M})")
def bilateral(sharpness, near, image, out):
    """A 5x5 bilateral filter: weights by distance, and by likeness to the middle."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            middle = image[y + 2, x + 2]
            total = np.float32(0.0)
            weights = np.float32(0.0)
            for dy in range(5):
                for dx in range(5):
                    value = image[y + dy, x + dx]
                    away = value - middle
                    weight = near[dy, dx] * math.exp(-sharpness * away * away)
                    total += weight * value
                    weights += weight
            out[y, x] = total / weights


@vividc.kernel(f"void(float32, {M}, {M})")
def bicubic(scale, image, out):
    """Enlarges an image with cubic weights (Catmull-Rom) of 4x4 pixels."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            row = ONE + np.float32(y) * scale
            column = ONE + np.float32(x) * scale
            top = int(row)
            left = int(column)
            total = np.float32(0.0)
            for i in range(4):
                away = abs(row - np.float32(top + i - 1))
                if away < ONE:
                    down = (np.float32(1.5) * away - np.float32(2.5)) * away * away + ONE
                else:
                    near = (np.float32(2.5) - HALF * away) * away - np.float32(4.0)
                    down = near * away + TWO
                for j in range(4):
                    away = abs(column - np.float32(left + j - 1))
                    if away < ONE:
                        across = (np.float32(1.5) * away - np.float32(2.5)) * away * away + ONE
                    else:
                        near = (np.float32(2.5) - HALF * away) * away - np.float32(4.0)
                        across = near * away + TWO
                    total += down * across * image[top + i - 1, left + j - 1]
            out[y, x] = total


@vividc.kernel(f"void({V}, {M}, {M}, {M})")
def separable_blur(taps, image, between, out):
    """A blur along rows, then along columns."""
    n = len(taps)
    for y in range(image.shape[0]):
        for x in range(out.shape[1]):
            total = np.float32(0.0)
            for k in range(n):
                total += taps[k] * image[y, x + k]
            between[y, x] = total
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            total = np.float32(0.0)
            for k in range(n):
                total += taps[k] * between[y + k, x]
            out[y, x] = total


@vividc.kernel(f"void({M}, {M})")
def sphere_tracer(spheres, out):
    """How far rays through the pixels go until a step is short: sphere tracing of four spheres."""
    height, width = out.shape
    for y in range(height):
        for x in range(width):
            dx = (np.float32(x) + HALF) * TWO / np.float32(width) - ONE
            dy = (np.float32(y) + HALF) * TWO / np.float32(height) - ONE
            length = math.sqrt(dx * dx + dy * dy + ONE)
            dx /= length
            dy /= length
            dz = ONE / length
            t = np.float32(0.0)
            near = ONE
            while t < FAR and near > np.float32(0.01):
                near = FAR
                for s in range(spheres.shape[0]):
                    ox = t * dx - spheres[s, 0]
                    oy = t * dy - spheres[s, 1]
                    oz = t * dz - spheres[s, 2]
                    near = min(near, math.sqrt(ox * ox + oy * oy + oz * oz) - spheres[s, 3])
                t += near
            out[y, x] = t
