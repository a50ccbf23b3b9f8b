"""Integer operators on the array against numba, bit for bit, on pairs of words at their edges."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import vividc
from tests.e2e import integer_kernels as k
from tests.e2e.test_found import assert_agrees

EDGES = (0, 1, 2, 3, 10, 255, 65537, 2**30 + 1, 2**31 - 1)
VALUES = sorted({sign * edge for edge in EDGES for sign in (1, -1)} | {-(2**31)})
PAIRS = np.array(list(itertools.product(VALUES, VALUES)), np.int64).T


def pairs(dtype: type) -> tuple[np.ndarray, np.ndarray]:
    return PAIRS[0].astype(dtype), PAIRS[1].astype(dtype)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*took too long")
@pytest.mark.parametrize(
    ("kernel", "dtype"), [(k.signed_division, np.int32), (k.unsigned_division, np.uint32)]
)
def test_loops_of_divisions(kernel: vividc.KernelFunction, dtype: type) -> None:
    a, b = pairs(dtype)
    assert_agrees(kernel, "vivid-tile", a, b, np.zeros_like(a), np.zeros_like(a))


@pytest.mark.parametrize(
    ("kernel", "dtype"), [(k.signed_once, np.int32), (k.unsigned_once, np.uint32)]
)
def test_division_of_variables(kernel: vividc.KernelFunction, dtype: type) -> None:
    program = vividc.compile(kernel, effort="fast")
    for a, b in zip(*(column[::5].tolist() for column in pairs(dtype)), strict=True):
        mine, theirs = np.zeros(2, dtype), np.zeros(2, dtype)
        vividc.simulate(program, dtype(a), dtype(b), mine)
        kernel(a, b, theirs)
        assert np.array_equal(mine, theirs), (a, b)


@pytest.mark.parametrize("divisor", [7, -10, 0, -(2**31)])
def test_division_by_a_parameter(divisor: int) -> None:
    a = np.array(VALUES, np.int32)
    zeros = np.zeros_like(a)
    assert_agrees(k.by_a_parameter, "vivid-tile", a, np.int32(divisor), zeros, zeros.copy())


def test_division_by_constants() -> None:
    a = np.array(VALUES, np.int32)
    assert_agrees(k.by_constants, "vivid-tile", a, np.zeros_like(a), np.zeros(len(a), np.uint32))


def test_rotations_and_small_products() -> None:
    a, b = pairs(np.uint32)
    assert_agrees(k.rotations, "vivid-tile", a, b, np.zeros_like(a))


def test_a_loop_divides_by_a_parameter_in_a_few_cycles() -> None:
    """Its reciprocal is computed once, before the loop, which there may be one of for zero."""
    loops = [r for r in vividc.compile(k.by_a_parameter).regions if r.kind == "loop"]
    assert loops
    assert all(loop.ii is not None and loop.ii <= 4 for loop in loops)
