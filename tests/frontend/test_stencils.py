"""Functions made by `numba.stencil` compute in kernels, and as kernels, what numba's do."""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import run_regions
from vividc.compiler.driver import lower

SIGNATURE = "(float32[:, ::1], float32[:, ::1], int32)"


@numba.stencil
def smoothed(a):
    return np.float32(0.25) * (a[0, 1] + a[0, -1] + a[1, 0] + a[-1, 0])


@numba.stencil(cval=1.5)
def chosen(a, b, least):
    if a[0] > least:
        return a[-1] * b[2]
    return a[0]


@numba.stencil(neighborhood=((-2, 0),), standard_indexing=("weights",))
def weighted(a, weights):
    total = np.float32(0)
    for i in range(-2, 1):
        total += a[i] * weights[i + 2]
    return total


def into_each_other(x, y, n):
    smoothed(x, out=y)
    for _ in range(n):
        x, y = y, x
        smoothed(x, out=y)
    return smoothed(y)


def of_rows(x, y, n):
    y[1, :] = chosen(x[0], x[n], np.float32(0.4))
    return weighted(x[n], y[0, :3])


@pytest.mark.parametrize("function", [into_each_other, of_rows])
def test_stencils_in_kernels_are_numbas(function: Callable[..., object]) -> None:
    kernel = vividc.kernel(SIGNATURE)(function)
    lowered = lower(kernel)
    x, y = np.random.default_rng(3).random((2, 6, 7)).astype(np.float32)
    theirs, mine = [x.copy(), y.copy()], [x.copy(), y.copy()]
    expected = kernel(*theirs, 2)
    found = run_regions(lowered, [*mine, np.int32(2)])
    np.testing.assert_allclose(mine, theirs, rtol=1e-6)
    assert found is None or np.allclose(found, expected)


@numba.stencil
def halved(a):
    return 0.5 * a[1, 0]


@numba.njit
def written_in_another_type(x, y):
    y = halved(x, out=y)
    return y + halved(y)


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
def test_an_out_has_a_type_of_its_own() -> None:
    """Numba has no such call where both differ: its own is that of float64."""
    x = np.random.default_rng(5).random((5, 6)).astype(np.float32)
    y, wide = np.zeros((5, 6), np.float32), np.zeros((5, 6))
    expected = written_in_another_type(x.astype(np.float64), wide)
    found = vividc.jit(written_in_another_type, effort="fast")(x, y)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    np.testing.assert_allclose(y, wide, rtol=1e-6)


def test_a_stencil_is_a_kernel() -> None:
    x = np.random.default_rng(4).random((5, 6)).astype(np.float32)
    jitted = vividc.jit(smoothed, effort="fast")
    np.testing.assert_allclose(jitted(x), smoothed(x), rtol=1e-6)


def test_arrays_that_are_too_small_are_told() -> None:
    jitted = vividc.jit(numba.njit(lambda a, b: chosen(a, b, np.float32(0))), effort="fast")
    long, short = np.ones(7, np.float32), np.ones(6, np.float32)
    with pytest.raises(ValueError, match="smaller the same dimension"):
        jitted(long, short)
