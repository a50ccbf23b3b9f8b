"""Functions made by `numba.vectorize` compute in kernels what numba's do, and convert their
arguments alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
import pytest

import vividc
from vividc.errors import KernelError
from vividc.ssa.interpret import interpret

SIGNATURE = "(float32[:, ::1], float32[:, ::1], int32[::1])"


@numba.vectorize
def blended(x, y):
    return x * y + np.float32(1) if x > y else y


@numba.vectorize(["int32(int32)", "float32(float32)"])
def squared(x):
    return x * x if x > 0 else x


def whole(a, b, n):
    b[:] = blended(a, b)


def parts_in_an_expression(a, b, n):
    b[1:] = blended(a[:-1], np.float32(2)) + squared(a[1:]) * b[0]


def numbers(a, b, n):
    for i in range(a.shape[0]):
        b[i, i] = blended(a[i, 0], a[0, i])


def integers(a, b, n):
    n[:] = squared(n) + squared(n[0])


@pytest.mark.parametrize("function", [whole, parts_in_an_expression, numbers, integers])
def test_elements_are_numbas(function: Callable[..., object]) -> None:
    kernel = vividc.kernel(SIGNATURE)(function)
    lowered = kernel.lower()
    a = np.arange(16, dtype=np.float32).reshape(4, 4)
    mine, theirs = a[::-1].copy(), a[::-1].copy()
    n, numbers = np.arange(5, -3, -2, dtype=np.int32), np.arange(5, -3, -2, dtype=np.int32)
    kernel(a.copy(), theirs, numbers)
    interpret(lowered, a, mine, n)
    np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(n, numbers)


def written_to_an_out(a, b, n):
    blended(a, a, b)


def test_an_out_is_refused() -> None:
    with pytest.raises(KernelError, match="blended"):
        vividc.kernel(SIGNATURE)(written_to_an_out).lower()


def test_a_function_of_elements_is_a_kernel_of_arrays_and_numbers() -> None:
    jitted = vividc.jit(blended, effort="fast")
    a, b = np.arange(6, dtype=np.float32).reshape(2, 3), np.full(3, 2, np.float32)
    np.testing.assert_array_equal(jitted(a, b), blended(a, b))
    np.testing.assert_array_equal(jitted.reference(a, b), blended(a, b))
    assert jitted(np.float32(3), np.float32(2)) == 7
    kernel = vividc.kernel("(int32[::1],)")(squared)
    assert (kernel.name, kernel.params[0].name) == ("squared", "x")
    assert kernel.line == squared._dispatcher.py_func.__code__.co_firstlineno
