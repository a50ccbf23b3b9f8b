"""Kernels with elementary functions against numba."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import vividc
from tests.e2e.elementary_kernels import EXACT, LOOPS, STRAIGHT, literals, remainders, waves
from vividc.errors import KernelError, VividcWarning
from vividc.frontend import KernelFunction

RTOL = 1e-6
"""docs/math.md: 4.8 ulp at most, of 1.2e-7 each, and numba's own; sums of two are fused."""
UNIT = "vivid-tile-unit"


def both(kernel: KernelFunction, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The array's rows and numba's."""
    mine, theirs = rows.copy(), rows.copy()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        program = vividc.compile(kernel, fabric=UNIT, effort="fast")
    for row in mine:
        vividc.simulate(program, row)
    for row in theirs:
        kernel(row)
    return mine, theirs


@pytest.mark.parametrize("kernel", STRAIGHT, ids=lambda kernel: kernel.name)
def test_straight_code(kernel: KernelFunction) -> None:
    rows = np.random.default_rng(6).uniform(1.0, 6.0, (8, 5)).astype(np.float32)
    mine, theirs = both(kernel, rows)
    np.testing.assert_allclose(mine, theirs, rtol=RTOL)


@pytest.mark.parametrize("kernel", EXACT, ids=lambda kernel: kernel.name)
def test_remainders_and_roundings_are_exact(kernel: KernelFunction) -> None:
    rng = np.random.default_rng(7)
    rows = rng.uniform(-50.0, 50.0, (8, 5)).astype(np.float32)
    mine, theirs = both(kernel, rows)
    assert np.array_equal(mine.view(np.uint32), theirs.view(np.uint32))


def test_a_remainder_of_a_huge_quotient_is_exact() -> None:
    rows = np.array([[1e38, 3e-38, 1, 1, 1], [3e38, 1e-45, 1, 1, 1]], np.float32)
    mine, theirs = both(remainders, rows)
    assert np.array_equal(mine, theirs)


def test_a_huge_angle_is_reduced() -> None:
    rows = np.array([[1e30, 2.5e37, 1e22, 0, 0]], np.float32)
    mine, theirs = both(waves, rows)
    np.testing.assert_allclose(mine, theirs, rtol=RTOL)


@pytest.mark.parametrize("kernel", LOOPS, ids=lambda kernel: kernel.name)
def test_loops(kernel: KernelFunction) -> None:
    rows = np.random.default_rng(8).uniform(-9.0, 9.0, (1, 20)).astype(np.float32)
    mine, theirs = both(kernel, rows)
    np.testing.assert_allclose(mine, theirs, rtol=RTOL)


def test_a_function_of_a_float64_warns_of_its_line() -> None:
    with pytest.warns(VividcWarning, match="float64 arithmetic"):
        vividc.compile(literals, fabric=UNIT)
    with pytest.raises(KernelError, match="float64"):
        vividc.compile(literals, fabric=UNIT, strict_fp=True)
