"""Small kernels on integers of less than a word, with the operations that their loop needs."""

import numpy as np

from vividc.frontend import kernel


@kernel("void(uint8[::1], uint8[::1])")
def next_byte(x, y):
    for i in range(x.shape[0]):
        y[i] = x[i] + 1


@kernel("void(int8[::1], int16[::1])")
def double_byte(x, y):
    for i in range(x.shape[0]):
        y[i] = 2 * x[i]


@kernel("void(int16[::1], boolean[::1], int16)")
def above(x, y, level):
    for i in range(x.shape[0]):
        y[i] = x[i] > level


@kernel("void(int8[::1], int8[::1])")
def clip(x, y):
    for i in range(x.shape[0]):
        y[i] = min(max(x[i], -5), 100)


@kernel("void(uint16[::1], uint8[::1])")
def high_byte(x, y):
    for i in range(x.shape[0]):
        y[i] = x[i] >> 8


@kernel("void(int16[::1], int8[::1])")
def cut_to_byte(x, y):
    for i in range(x.shape[0]):
        y[i] = x[i]


@kernel("int8(int8[::1])")
def smallest(x):
    best = x[0]
    for i in range(x.shape[0]):
        best = min(best, x[i])
    return best


@kernel("uint8(uint8, int8, uint16, int16, boolean)")
def mixed_scalars(a, b, c, d, e):
    return np.uint8((a + b) * (c - d) + e)


@kernel("int16(int8)")
def negated(a):
    return np.int16(-a)


@kernel("float32(int16)")
def as_float(a):
    return np.float32(a)


@kernel("void(float32[::1], int8[::1])")
def from_float(x, y):
    for i in range(x.shape[0]):
        y[i] = np.int8(x[i])


@kernel("void(uint8[::1], uint8[::1])")
def rotate_bits(x, y):
    for i in range(x.shape[0]):
        v = np.uint8(x[i])
        y[i] = np.uint8(np.uint8(v << 3) | np.uint8(v >> 5))


@kernel("void(boolean[:, ::1], boolean[::1])")
def any_in_row(x, y):
    for i in range(x.shape[0]):
        found = False
        for j in range(x.shape[1]):
            found = found or x[i, j]
        y[i] = found and not y[i]


@kernel("void(int8[:, :, ::1], uint16[:, ::1])")
def planes(x, y):
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            for k in range(x.shape[2]):
                y[-j, i] += x[i, j, -k]
