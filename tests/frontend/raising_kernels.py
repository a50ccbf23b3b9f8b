"""Kernels that raise; pytest would write the `assert` of a test's module anew."""

from __future__ import annotations

import numpy as np

import vividc


def roots(x, n):
    for i in range(n):
        if x[i] < 0:
            raise ValueError("a negative number, at x[i]")  # here
        x[i] = np.sqrt(x[i])
    return x.sum()


def checked(x, n):
    x[0] = n
    assert n < 4, "too many"  # here
    return x[:n] * np.float32(2)


def helper(x, n):
    if n > 3:
        raise OverflowError  # here
    return n


HELPED = vividc.kernel("int64(float32[::1], int32)")(helper)


def through_a_helper(x, n):
    x[1] = HELPED(x, n)


def worded(x, n):
    x[0] = n
    if n == 3:
        raise StopIteration
    if n == 4:
        raise ZeroDivisionError("division by zero: None")
    if n == 5:
        raise ValueError('zero-size or incompatible "axis" of 100 % \\ é\n')
    return x[0]


def numbered(x, n):
    if n != 0:
        raise ValueError(f"n is {n}, {n > 2} of {len(x)}")
    return n


def asserted(x, n):
    assert n == 0, f"{n}"
    return n


def added(x, n):
    text = "element 2 is " + str(x[2]) + ", 100% wrong"
    if n != 0:
        raise RuntimeError(text)
    return n


def two_arguments(x, n):
    if n != 0:
        raise IndexError("bad", n)
    return n


def a_number(x, n):
    if n != 0:
        raise KeyError(n * 2)
    return n


SAYING = (numbered, asserted, added, two_arguments, a_number)
