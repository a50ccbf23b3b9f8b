"""`np.cov` of matrices gives what numpy's does, for each of its arguments."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.ssa.interpret import interpret


def of_rows(a, c):
    c[:] = np.cov(a)


def of_columns(a, c):
    c[:] = np.cov(a, rowvar=False)


def of_a_transposed(a, c):
    c[:] = np.cov(a.T)


def biased(a, c):
    c[:] = np.cov(a, bias=True)


def of_all(a, c):
    c[:] = np.cov(a, ddof=0)


def of_two_less(a, c):
    c[:] = np.cov(a, None, True, False, 2)


EVERY = {
    of_rows: {},
    of_columns: {"rowvar": False},
    of_a_transposed: {"rowvar": False},
    biased: {"bias": True},
    of_all: {"ddof": 0},
    of_two_less: {"ddof": 2},
}


@pytest.mark.filterwarnings("ignore:.*runs in float32")
@pytest.mark.parametrize("function", EVERY, ids=lambda one: one.__name__)
@pytest.mark.parametrize("dtype", ["float32", "int32"])
def test_every_argument(function: object, dtype: str) -> None:
    lowered = vividc.kernel(f"({dtype}[:, ::1], float32[:, ::1])")(function).lower()
    for shape in ((4, 6), (6, 4), (2, 3)):
        a = np.random.default_rng(0).integers(-9, 9, shape).astype(dtype)
        expected = np.cov(a, **EVERY[function])
        found = np.ones(expected.shape, np.float32)
        interpret(lowered, a, found)
        assert np.allclose(found, expected, rtol=1e-5, atol=1e-5)
        assert np.array_equal(found, found.T)


@pytest.mark.filterwarnings("ignore:.*runs in float32")
def test_no_columns_have_no_covariance() -> None:
    lowered = vividc.kernel("(float32[:, ::1], float32[:, ::1])")(of_rows).lower()
    found = np.ones((3, 3), np.float32)
    interpret(lowered, np.zeros((3, 0), np.float32), found)
    assert np.isnan(found).all()


@pytest.mark.filterwarnings("ignore:.*runs in float32")
def test_a_single_row_is_refused_as_by_numba() -> None:
    lowered = vividc.kernel("(float32[:, ::1], float32[:, ::1])")(of_rows).lower()
    with pytest.raises(RuntimeError, match="2D array containing a single row is unsupported"):
        interpret(lowered, np.zeros((1, 5), np.float32), np.ones((1, 1), np.float32))
