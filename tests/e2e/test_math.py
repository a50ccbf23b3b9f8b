"""Kernels with division and elementary functions against numba."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.e2e.math_kernels import EVERY_ITERATION, INVARIANT
from vividc.frontend import KernelFunction

RTOL = 1e-5
"""Divisions and roots are exact to the last bit; the array's exp is within an ulp, sums of 20 terms
are fused, and a difference of arguments near 20 costs exp 20 of its ulps.
"""
TILE, UNIT = "vivid-tile", "vivid-tile-unit"


def assert_array_gives_what_numba_gives(kernel: KernelFunction, fabric: str) -> None:
    theirs = np.random.default_rng(5).uniform(-9.0, 9.0, 20).astype(np.float32)
    mine = theirs.copy()
    program = vividc.compile(kernel, fabric=fabric, effort="fast")
    result = vividc.simulate(program, mine)
    value = kernel(theirs)
    np.testing.assert_allclose(mine, theirs, rtol=RTOL)
    if value is not None:
        np.testing.assert_allclose(result.value, value, rtol=RTOL)


@pytest.mark.parametrize("fabric", [TILE, UNIT])
@pytest.mark.parametrize("kernel", INVARIANT, ids=lambda kernel: kernel.name)
def test_divisions_outside_the_loop(kernel: KernelFunction, fabric: str) -> None:
    assert_array_gives_what_numba_gives(kernel, fabric)


@pytest.mark.parametrize("kernel", EVERY_ITERATION, ids=lambda kernel: kernel.name)
def test_divisions_in_the_loop(kernel: KernelFunction) -> None:
    assert_array_gives_what_numba_gives(kernel, UNIT)


@pytest.mark.slow
@pytest.mark.parametrize("kernel", EVERY_ITERATION, ids=lambda kernel: kernel.name)
def test_divisions_in_the_loop_of_long_latencies(kernel: KernelFunction) -> None:
    """The mapper uses up its time to prove the II."""
    assert_array_gives_what_numba_gives(kernel, TILE)
