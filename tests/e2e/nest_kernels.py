"""Nests whose flattened form has to keep something in order, or need not."""

import numpy as np

import vividc

ZERO = np.float32(0.0)


@vividc.kernel("void(int32[:, ::1], int32)")
def scale(a, factor):
    """Whole rows: one affine index."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] = np.int32(a[i, j] * factor)


@vividc.kernel("void(int32[:, ::1], int32[::1])")
def add_inside(a, x):
    """Rows without their ends, in place: no element comes back."""
    for i in range(a.shape[0]):
        for j in range(1, a.shape[1] - 1):
            a[i, j] = np.int32(a[i, j] + x[j])


@vividc.kernel("void(int32[:, ::1])")
def scan_rows(a):
    """Each element needs the one before it."""
    for i in range(a.shape[0]):
        for j in range(1, a.shape[1]):
            a[i, j] = np.int32(a[i, j] + a[i, j - 1])


@vividc.kernel("void(int32[:, ::1])")
def scan_columns(a):
    """Each element needs the one above it."""
    for i in range(1, a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] = np.int32(a[i, j] + a[i - 1, j])


@vividc.kernel("void(int32[:, ::1])")
def columns_first(a):
    """The outer counter is the column, and runs backwards."""
    for j in range(a.shape[1] - 1, -1, -1):
        for i in range(a.shape[0]):
            a[i, j] = np.int32(3 * a[i, j] + i - j)


@vividc.kernel("void(int32[:, ::1], int32[::1])")
def row_sums_in_memory(a, total):
    """The inner loop comes back to one element again and again."""
    for i in range(a.shape[0]):
        total[i] = i
        for j in range(a.shape[1]):
            total[i] = np.int32(total[i] + a[i, j])
        total[i] = np.int32(total[i] * 2)


@vividc.kernel("void(int32[:, ::1], int32[::1], int32[::1])")
def weighted_rows(a, x, y):
    """Loads and stores of y around the inner loop: once for each row."""
    for i in range(a.shape[0]):
        start = y[i]
        total = np.int32(0)
        for j in range(a.shape[1]):
            total = np.int32(total + a[i, j] * x[j])
        y[i] = np.int32(start + total)


@vividc.kernel("void(int32[::1], int32)")
def stairs(a, n):
    """A triangle, with a word that outer iterations hand on through memory."""
    for i in range(n):
        for j in range(i):
            a[i] = np.int32(a[i] + a[j])
        a[0] = np.int32(a[0] + a[i])


@vividc.kernel("int32(int32[:, ::1], int32)")
def first_large(a, limit):
    """Left from the inner loop, with both counters in use afterwards."""
    seen = 0
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            if a[i, j] > limit:
                return i * 100 + j + seen
        seen += 1000
    return -seen


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32[:, ::1])")
def product(a, b, c):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = c[i, j]
            for k in range(a.shape[1]):
                total = np.int32(total + a[i, k] * b[k, j])
            c[i, j] = total


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def smooth(a, b, rounds):
    """Siblings in a loop: each of them becomes one loop."""
    for _ in range(rounds):
        for i in range(1, a.shape[0] - 1):
            for j in range(1, a.shape[1] - 1):
                b[i, j] = np.int32(a[i - 1, j] + a[i + 1, j] + a[i, j - 1] + a[i, j + 1]) >> 2
        for i in range(1, a.shape[0] - 1):
            for j in range(1, a.shape[1] - 1):
                a[i, j] = b[i, j]
