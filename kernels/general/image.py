"""Images, stencils and cellular automata."""

import numba
import numpy as np

import vividc

RADIUS = 2
BORN = 3
SURVIVES = 2
QUARTER = np.float32(0.25)
SIXTH = np.float32(1 / 6)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def conv2d(image, weights, out):
    """Valid 2-D correlation with weights of any size."""
    rows, columns = weights.shape
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            total = np.float32(0.0)
            for dy in range(rows):
                for dx in range(columns):
                    total += weights[dy, dx] * image[y + dy, x + dx]
            out[y, x] = total


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def blur3(image, out):
    """3x3 binomial blur of the inner pixels."""
    for y in range(1, image.shape[0] - 1):
        for x in range(1, image.shape[1] - 1):
            top = image[y - 1, x - 1] + 2 * image[y - 1, x] + image[y - 1, x + 1]
            middle = image[y, x - 1] + 2 * image[y, x] + image[y, x + 1]
            bottom = image[y + 1, x - 1] + 2 * image[y + 1, x] + image[y + 1, x + 1]
            out[y, x] = np.int32(top + 2 * middle + bottom + 8) >> 4


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def sobel(image, out):
    """Gradient magnitude |gx| + |gy|, at most 255."""
    for y in range(1, image.shape[0] - 1):
        for x in range(1, image.shape[1] - 1):
            gx = (
                image[y - 1, x + 1]
                + 2 * image[y, x + 1]
                + image[y + 1, x + 1]
                - image[y - 1, x - 1]
                - 2 * image[y, x - 1]
                - image[y + 1, x - 1]
            )
            gy = (
                image[y + 1, x - 1]
                + 2 * image[y + 1, x]
                + image[y + 1, x + 1]
                - image[y - 1, x - 1]
                - 2 * image[y - 1, x]
                - image[y - 1, x + 1]
            )
            out[y, x] = min(np.int32(abs(np.int32(gx)) + abs(np.int32(gy))), 255)


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def dilate(image, out):
    """The largest pixel of a square around each pixel, cut off at the borders."""
    height, width = image.shape
    for y in range(height):
        for x in range(width):
            best = image[y, x]
            for v in range(max(0, y - RADIUS), min(height, y + RADIUS + 1)):
                for u in range(max(0, x - RADIUS), min(width, x + RADIUS + 1)):
                    best = max(best, image[v, u])
            out[y, x] = best


@vividc.kernel("int32(int32[::1], int32, int32)")
def threshold(image, low, high):
    """Three levels in place; returns how many pixels are above `high`."""
    above = 0
    for i in range(len(image)):
        if image[i] < low:
            image[i] = 0
        elif image[i] <= high:
            image[i] = 128
        else:
            image[i] = 255
            above += 1
    return above


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def lookup(image, table, out):
    """Each pixel through a table of 256."""
    for i in range(len(image)):
        out[i] = table[image[i] & 255]


@vividc.kernel("void(int32[::1], int32[::1])")
def histogram(image, counts):
    for value in image:
        counts[value] += 1


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], int32)")
def jacobi(a, b, steps):
    """Averages of four neighbours, from a to b and back."""
    n, m = a.shape
    for _ in range(steps):
        for i in range(1, n - 1):
            for j in range(1, m - 1):
                b[i, j] = QUARTER * (a[i - 1, j] + a[i + 1, j] + a[i, j - 1] + a[i, j + 1])
        for i in range(1, n - 1):
            for j in range(1, m - 1):
                a[i, j] = b[i, j]


@vividc.kernel("void(float32[:, ::1], int32)")
def gauss_seidel(a, steps):
    """The same in place: each average uses the new values above and to the left."""
    for _ in range(steps):
        for i in range(1, a.shape[0] - 1):
            for j in range(1, a.shape[1] - 1):
                a[i, j] = QUARTER * (a[i - 1, j] + a[i + 1, j] + a[i, j - 1] + a[i, j + 1])


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1])")
def stencil7(a, out):
    """Averages of six neighbours in a volume."""
    depth, height, width = a.shape
    for z in range(1, depth - 1):
        for y in range(1, height - 1):
            for x in range(1, width - 1):
                total = a[z - 1, y, x] + a[z + 1, y, x] + a[z, y - 1, x]
                total += a[z, y + 1, x] + a[z, y, x - 1] + a[z, y, x + 1]
                out[z, y, x] = total * SIXTH


@numba.njit
def wrap(i, n):
    """An index at most one step outside 0 .. n - 1, brought back on a ring."""
    if i < 0:
        return n - 1
    return 0 if i == n else i


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def life(world, after):
    """One step of Conway's game of life on a torus."""
    height, width = world.shape
    for y in range(height):
        for x in range(width):
            alive = 0
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    if dy == 0 and dx == 0:
                        continue
                    alive += world[wrap(y + dy, height), wrap(x + dx, width)]
            if alive == BORN or (alive == SURVIVES and world[y, x] == 1):
                after[y, x] = 1
            else:
                after[y, x] = 0
