"""Kernels of `tests/test_hints.py`: a mistake each, and what its hint says instead."""

from __future__ import annotations

import numba
import numpy as np

FACTOR = 3


def add(x, y, n):
    for i in range(n):
        y[i] += x[i]


def spread(x, y, n):
    for i in numba.prange(n):
        y[i] += x[i]


def endless(x, y, n):
    while True:
        y[0] += x[0]


def broken(x, y, n):
    while True:
        y[0] += x[0]
        if y[0] > n:
            break


def unsized(x, y, n):
    t = np.zeros(x[0], np.float32)
    y[0] = t[0]


def sized(x, y, n):
    t = np.zeros(len(x), np.float32)
    y[0] = t[0]


def texts(x, y, n):
    return "done"


def numbers(x, y, n):
    return np.int32(1)


def misspelt(x, y, n):
    y[0] = np.minimun(x[0], n)


def spelt(x, y, n):
    y[0] = np.minimum(x[0], n)


def printing(x, y, n):
    print(x[0])


def storing(x, y, n):
    y[0] = x[0]


def dicts(x, y, n):
    t = {1: n}
    y[0] = t[1]


def keys_as_indices(x, y, n):
    t = np.zeros(16, np.int32)
    t[1] = n
    y[0] = t[1]


def truth(x, y, n):
    if x:
        y[0] = 1


def truth_of_some(x, y, n):
    if (x > 0).any() or x[0] > 0:
        y[0] = 1


def tries(x, y, n):
    try:
        y[0] = x[n]
    except Exception:
        y[0] = 0


def tested(x, y, n):
    y[0] = x[n] if 0 <= n < len(x) else 0


def mixed(x, y, n):
    t = (1, 2.5)
    y[0] = t[n]


def chosen(x, y, n):
    if n == 0:
        y[0] = 1
    elif n == 1:
        y[0] = np.int32(np.float32(2.5))


def complexes(x, y, n):
    t = np.zeros(4, "U3")
    y[0] = len(t[n])


def floats(x, y, n):
    t = np.zeros(16, np.float32)
    u = np.empty(16, np.int32)
    u[0] = n
    y[0] = t[0] + u[0]


def generates(x, y, n):
    y[0] = sum(v for v in x)


def loops(x, y, n):
    for v in x:
        y[0] += v


def item(x, y, n):
    y[0] = x.item()


def element(x, y, n):
    y[0] = x[0]


def undefined(x, y, n):
    y[0] = factor * x[0]  # noqa: F821 - the mistake


def defined(x, y, n):
    y[0] = FACTOR * x[0]
