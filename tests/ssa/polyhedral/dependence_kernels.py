"""Kernels whose accesses of one array meet where a test on strides alone does not tell."""

from __future__ import annotations

import numpy as np

from vividc.frontend import kernel

TWO, THREE = np.float32(2), np.float32(3)
COLUMNS = "void(float32[:, ::1], float32[::1], int32)"


@kernel(COLUMNS)
def backwards(a, x, n):
    for i in range(len(x) - 1, -1, -1):
        x[i] *= TWO


@kernel(COLUMNS)
def by_three(a, x, n):
    for i in range(n):
        x[3 * i] *= TWO


@kernel(COLUMNS)
def by_five_from_two(a, x, n):
    for i in range(n):
        x[5 * i + 2] *= TWO


@kernel(COLUMNS)
def rows(a, x, n):
    for i in range(a.shape[0] - 1):
        for j in range(a.shape[1]):
            a[i, j] *= TWO
            a[i + 1, j] *= THREE


@kernel(COLUMNS)
def columns(a, x, n):
    for i in range(a.shape[0]):
        a[i, 2] = a[n, 0] * TWO


@kernel(COLUMNS)
def halves(a, x, n):
    for i in range(n):
        x[i + n] = x[i] * TWO


@kernel(COLUMNS)
def triangle(a, x, n):
    for i in range(a.shape[0]):
        for j in range(i):
            a[i, j] = a[j, i] * TWO


@kernel(COLUMNS)
def one_behind(a, x, n):
    """Anti-dependences alone."""
    for i in range(len(x) - 1):
        x[i] = x[i + 1] * TWO


@kernel(COLUMNS)
def rows_backwards(a, x, n):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, a.shape[1] - 1 - j] *= TWO


@kernel(COLUMNS)
def one_column(a, x, n):
    for i in range(a.shape[0]):
        a[i, n] *= TWO


@kernel(COLUMNS)
def every_other(a, x, n):
    for i in range(n):
        x[2 * i] = x[4 * i + 1] * TWO


INDEPENDENT = (
    backwards,
    by_three,
    by_five_from_two,
    rows,
    columns,
    halves,
    triangle,
    one_behind,
    rows_backwards,
    one_column,
    every_other,
)
"""Their loops have an II of 1 if that is all that binds."""


@kernel(COLUMNS)
def from_the_end(a, x, n):
    """For some n, both ends of `x`: x[-1] is x[len(x) - 1]."""
    for i in range(3):
        x[2 * i + n] *= TWO


@kernel(COLUMNS)
def carried(a, x, n):
    for i in range(1, len(x)):
        x[i] = x[i - 1] * TWO


@kernel(COLUMNS)
def carried_backwards(a, x, n):
    for j in range(1, a.shape[1]):
        a[0, a.shape[1] - 1 - j] = a[0, a.shape[1] - j] * TWO


@kernel(COLUMNS)
def diagonal(a, x, n):
    for i in range(a.shape[0] - 1):
        for j in range(min(a.shape[0], a.shape[1])):
            a[i, j] = a[j, i] + a[i + 1, j]


@kernel(COLUMNS)
def at_the_edge(a, x, n):
    """The row before: LLVM knows that j is the number of columns."""
    for i in range(a.shape[0] - 1):
        for j in range(1, a.shape[1] + 1):
            if j == a.shape[1]:
                a[i, j - 1] += a[i + 1, 0]


@kernel(COLUMNS)
def flat(a, x, n):
    y = a.reshape(a.size)
    for i in range(a.shape[0] - 1):
        for j in range(a.shape[1]):
            y[i * a.shape[1] + j + 1] += a[i, j]


@kernel(COLUMNS)
def on_itself(a, x, n):
    for i in range(n):
        x[i] = x[2 * i] + x[i // 2]


@kernel(COLUMNS)
def one_place(a, x, n):
    for i in range(len(x)):
        a[n, 1] += x[i]


@kernel(COLUMNS)
def guarded(a, x, n):
    for i in range(len(x)):
        if i < n:
            x[i] = x[n] * TWO
        elif i > n:
            x[i] += x[i - n]


@kernel(COLUMNS)
def clamped(a, x, n):
    for i in range(len(x)):
        x[min(i, n)] += x[max(i - 2, 0)]


DEPENDENT = (
    from_the_end,
    carried,
    carried_backwards,
    diagonal,
    at_the_edge,
    flat,
    on_itself,
    one_place,
    guarded,
    clamped,
)


@kernel("void(int64, int64, float32[:, ::1])")
def sweeps(n, steps, u):
    """Recurrences along rows and columns, as statements on parts whose lengths are clipped."""
    p = np.zeros(u.shape, np.float32)
    q = np.zeros(u.shape, np.float32)
    for _ in range(steps):
        p[1 : n - 1, 0] = np.float32(0.0)
        q[1 : n - 1, 0] = u[0, 1 : n - 1]
        for j in range(1, n - 1):
            p[1 : n - 1, j] = p[1 : n - 1, j - 1] * np.float32(0.5) + np.float32(0.25)
            around = u[j, 0 : n - 2] + u[j, 1 : n - 1] - u[j, 2:n]
            q[1 : n - 1, j] = (around - q[1 : n - 1, j - 1]) * p[1 : n - 1, j - 1]
        for j in range(n - 2, 0, -1):
            u[j, 1 : n - 1] = p[1 : n - 1, j] * u[j + 1, 1 : n - 1] + q[1 : n - 1, j]
