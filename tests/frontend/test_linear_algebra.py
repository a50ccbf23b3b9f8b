"""Factors, inverses and solutions of small systems are numpy's but for rounding, and what has none
raises as in numba; axes are permuted as numpy permutes them.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import run_regions
from vividc.compiler.driver import lower
from vividc.errors import VividcError
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.polyhedral.scop import find_scop
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

SIDE = 5


def factor(a, b):
    b[:] = np.linalg.cholesky(a)


def inverse(a, b):
    b[:] = np.linalg.inv(a)


def solutions(a, b):
    b[:] = np.linalg.solve(a, b) + np.linalg.solve(a, b[0])


def of_real_numbers(a, b):
    b[:] = np.linalg.solve(a, b.real.copy()) + np.linalg.solve(b.real.copy(), a)


def permuted(a, b):
    b[:] = np.transpose(a, axes=(1, 0, 2)) - a.transpose((-2, 0, -1)).copy() * a.transpose(1, 0, 2)


def interpreted(function: Callable[..., object], dtype: str, *args: np.ndarray) -> None:
    dims = ", ".join([":"] * (args[0].ndim - 1) + ["::1"])
    kernel = vividc.kernel(f"({dtype}[{dims}], {dtype}[{dims}])")(function)
    interpret(kernel.lower(), *args)


def system(dtype: str) -> np.ndarray:
    """A matrix that is positive definite, and complex if the type is."""
    drawn = np.random.default_rng(0).random((2, SIDE, SIDE)) @ np.eye(SIDE)
    values = drawn[0] + (1j * drawn[1] if dtype == "complex64" else 0)
    return (values @ values.conj().T + np.eye(SIDE)).astype(dtype)


@pytest.mark.parametrize(
    ("function", "dtype"),
    [
        (factor, "float32"),
        (inverse, "float32"),
        (inverse, "complex64"),
        (solutions, "float32"),
        (of_real_numbers, "complex64"),
    ],
)
def test_systems_have_numpys_solutions(function: Callable[..., object], dtype: str) -> None:
    a, b = system(dtype), system(dtype)[::-1].copy()
    numpys = b.copy()
    function(a, numpys)
    interpreted(function, dtype, a.copy(), b)
    np.testing.assert_allclose(b, numpys, rtol=1e-4, atol=1e-5)


def test_the_largest_pivot_of_a_column_is_taken() -> None:
    a = np.array([[0, 1], [1, 0]], np.float32)
    b = np.empty_like(a)
    interpreted(inverse, "float32", a, b)
    np.testing.assert_array_equal(b, [[0, 1], [1, 0]])


@pytest.mark.parametrize("function", [factor, inverse])
def test_what_has_none_raises(function: Callable[..., object]) -> None:
    with pytest.raises(VividcError, match="LinAlgError: Matrix is"):
        interpreted(function, "float32", *np.zeros((2, SIDE, SIDE), np.float32))


@pytest.mark.parametrize("last", [0.0, -1.0, np.nan])
def test_a_matrix_that_turns_out_not_to_be_definite_has_no_factor(last: float) -> None:
    a = np.diag([2.0, 1.0, last, 1.0, 1.0]).astype(np.float32)
    with pytest.raises(VividcError, match="LinAlgError: Matrix is not positive definite"):
        interpreted(factor, "float32", a, np.zeros_like(a))


def test_a_factors_nest_has_one_exit_and_no_branches() -> None:
    kernel = vividc.kernel("(float32[:, ::1], float32[:, ::1])")(factor)
    function = tidy(kernel.lower())
    loops = find_loops(function)
    nested = [one for one in loops if sum(other.header in one.blocks for other in loops) == 4]
    assert len(nested) == 1
    header = nested[0].header
    assert not isinstance(find_scop(with_own_latches(function, header), header), Refusal)


def test_axes_are_permuted() -> None:
    a = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
    b, numpys = np.zeros((2, 3, 2, 4), np.float32)
    permuted(a, numpys)
    interpreted(permuted, "float32", a, b)
    np.testing.assert_array_equal(b, numpys)


def largest(a, b):
    square = a.reshape((5, 5))
    b[0] = np.argmax(square, axis=1)
    b[1] = np.argmin(square, axis=0)


def test_places_along_an_axis_are_numpys() -> None:
    a = np.random.default_rng(1).permutation(SIDE * SIDE).reshape(SIDE, SIDE).astype(np.int32)
    b, numpys = np.zeros((2, SIDE, SIDE), np.int32)
    largest(a, numpys)
    interpreted(largest, "int32", a, b)
    np.testing.assert_array_equal(b, numpys)


def crossed(a, b, m, n, x):
    x[0] = np.cross(a, b)
    x[1] = np.cross([0.0, 0.0, 1.0], a)
    x[2] = np.cross(a[:2], b) + np.cross(b, a[1:])
    x[3] = np.cross((1, 2, 3), b)
    x[4:8] = np.cross(m, n) + np.cross(m, a) + np.cross(b, n) + np.cross(m[:1], n)
    x[8:] = np.cross(m[:, :2], n)


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
def test_cross_products_are_numbas() -> None:
    signature = "(float32[::1], float32[::1], float32[:, ::1], float32[:, ::1], float32[:, ::1])"
    kernel = vividc.kernel(signature)(crossed)
    rng = np.random.default_rng(5)
    shapes = (3, 3, (4, 3), (4, 3), (12, 3))
    mine = [rng.random(shape).astype(np.float32) for shape in shapes]
    theirs = [array.copy() for array in mine]
    kernel(*theirs)
    run_regions(lower(kernel), [*mine])
    np.testing.assert_allclose(mine[-1], theirs[-1], rtol=1e-5, atol=1e-6)


@numba.njit
def of_two_types(a, m, x):
    wide = np.array([0.5, 0.25, 2.0])
    x[0] = a @ wide + wide @ a
    x[1:] = m @ wide + np.dot(wide, m) + (np.cross([0, 0, 1], a) @ m) @ a


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
def test_products_of_float32_and_float64_are_those_of_float64() -> None:
    """Numba has no such product: its own are those of float64 arguments."""
    rng = np.random.default_rng(6)
    mine = [rng.random(shape).astype(np.float32) for shape in (3, (3, 3), 4)]
    theirs = [array.astype(np.float64) for array in mine]
    of_two_types(*theirs)
    vividc.jit(of_two_types, effort="fast")(*mine)
    np.testing.assert_allclose(mine[-1], theirs[-1], rtol=1e-5)


def crossed_vectors(a, b):
    return np.cross(a, b)


@pytest.mark.parametrize(("length", "text"), [(4, "Incompatible dimensions"), (2, "cross2d")])
def test_vectors_without_a_cross_product_raise(length: int, text: str) -> None:
    jitted = vividc.jit(crossed_vectors, effort="fast")
    vector = np.ones(length, np.float32)
    with pytest.raises(VividcError, match=text):
        jitted(vector, vector)
