"""Functions made by `numba.guvectorize` compute in kernels, and as kernels, what numba's do."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import KernelError


@numba.guvectorize(["void(float32[:], float32[:], float32[:])"], "(n),(n)->()")
def dot(a, b, result):
    total = np.float32(0)
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    result[0] = total


@numba.guvectorize(
    ["void(int32[:], int32, int32[:])", "void(float32[:], float32, float32[:])"], "(n),()->(n)"
)
def raised(a, by, result):
    for i in range(a.shape[0]):
        result[i] = a[i] + by


@numba.guvectorize(["void(float32[:, :], float32[:, :], float32[:, :])"], "(m,k),(k,n)->(m,n)")
def product(a, b, result):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            result[i, j] = total


@numba.guvectorize(["void(float32[:], float32[:], int64[:])"], "(n)->(),()")
def largest(a, value, place):
    value[0], place[0] = a[0], 0
    for i in range(1, len(a)):
        if a[i] > value[0]:
            value[0], place[0] = a[i], i


@numba.guvectorize("(n),()->(n)")
def shifted(a, by, result):
    for i in range(len(a)):
        result[i] = a[i] - by


@numba.guvectorize(["void(float32, float32[:], float32[:])"], "(),()->()")
def inner(r0, n0, empty):  # its names are those of what is written around it
    empty[0] = r0 * n0[0] + 1


X = np.linspace(-1, 1, 6, dtype=np.float32)
A = np.outer(np.arange(1, 5), X).astype(np.float32)
B = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
INTEGERS = np.arange(4, dtype=np.int32)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (dot, (A, A)),
        (dot, (A, X)),
        (dot, (B, B[0])),
        (dot, (X, X)),
        (raised, (A, np.arange(4, dtype=np.float32))),
        (raised, (A, np.float32(2))),
        (raised, (INTEGERS, np.int32(2))),
        (product, (B, B.transpose(0, 2, 1).copy())),
        (product, (B, A[:, :3].copy())),
        (largest, (A,)),
        (inner, (A, X)),
        (inner, (np.float32(2), np.float32(3))),
    ],
)
def test_results_are_numbas(function: Any, arguments: tuple[Any, ...]) -> None:
    jitted = vividc.jit(function, effort="fast")
    found, expected = jitted(*arguments), function(*arguments)
    host = jitted.reference(*arguments)
    if not isinstance(expected, tuple):
        found, host, expected = (found,), (host,), (expected,)
    for one, again, other in zip(found, host, expected, strict=True):
        assert np.shape(one) == np.shape(other)
        np.testing.assert_allclose(one, other, rtol=1e-5)
        np.testing.assert_allclose(again, other, rtol=1e-5)


def test_arrays_that_are_given_are_filled() -> None:
    mine, theirs = np.zeros(4, np.float32), np.zeros(4, np.float32)
    dot(A, X, theirs)
    assert vividc.jit(dot, effort="fast")(A, X, mine) is None
    np.testing.assert_allclose(mine, theirs, rtol=1e-5)
    kernel = vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")(dot)
    assert kernel.name == "dot"
    mine[:] = 0
    vividc.simulate(words_in_blocks(kernel.lower()), A, X, mine)
    np.testing.assert_allclose(mine, theirs, rtol=1e-5)
    mine = np.zeros_like(A)
    vividc.jit(shifted, effort="fast")(A, np.float32(1), mine)
    np.testing.assert_array_equal(mine, A - 1)


def whole(a, x, out):
    dot(a, x, out)
    moved = np.empty_like(a)
    shifted(a, x[0], moved)
    best, place = np.zeros(4, np.float32), np.zeros(4, np.int64)
    largest(moved, best, place)
    for i in range(4):
        out[i] += best[i] + np.float32(place[i])


def test_kernels_call_them() -> None:
    kernel = vividc.kernel("(float32[:, ::1], float32[::1], float32[::1])")(whole)
    mine, theirs = np.zeros(4, np.float32), np.zeros(4, np.float32)
    numba.njit(whole)(A, X, theirs)
    vividc.simulate(words_in_blocks(kernel.lower()), A, X, mine)
    np.testing.assert_allclose(mine, theirs, rtol=1e-5)


@pytest.mark.parametrize(
    ("function", "arguments", "text"),
    [
        (dot, (A, X[:3].copy()), "core dimension"),
        (inner, (A, np.arange(4, dtype=np.float32)), "could not be broadcast together"),
    ],
)
def test_sizes_that_do_not_fit_are_raised(
    function: Any, arguments: tuple[Any, ...], text: str
) -> None:
    with pytest.raises(ValueError, match=text):
        function(*arguments)
    with pytest.raises(ValueError, match=text):
        vividc.jit(function, effort="fast")(*arguments)


def without_the_result(a, x, out):
    out[:] = dot(a, x)


def of_too_few_dimensions(a, x, out):
    product(a, x, out)


@pytest.mark.parametrize("function", [without_the_result, of_too_few_dimensions])
def test_calls_that_do_not_fit_are_refused(function: Any) -> None:
    with pytest.raises(KernelError):
        vividc.kernel("(float32[:, ::1], float32[::1], float32[::1])")(function).lower()
