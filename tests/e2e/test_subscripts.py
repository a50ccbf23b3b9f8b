"""Constant subscripts free accesses from each other, and never one that may meet another."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import vividc
from kernels.render.encodings import sh_direction
from kernels.render.gaussians import covariance_3d
from tests.frontend import subscript_kernels as k
from tests.frontend.test_subscripts import Load, load  # noqa: F401 - a fixture
from vividc import arch
from vividc.compiler.driver import lower
from vividc.mapper import MapProblem
from vividc.mapper.bounds.bounds import all_bounds

MACHINE = arch.load("vivid-tile")


def bounds_of_loop(kernel: vividc.KernelFunction) -> dict[str, int]:
    loops = [region for region in lower(kernel).regions if region.kind == "loop"]
    return {bound.name: bound.ii for bound in all_bounds(MapProblem(loops[0].dfg, MACHINE))}


@pytest.mark.parametrize("kernel", [sh_direction, covariance_3d])
def test_stores_to_the_columns_of_a_row_wait_for_no_other(kernel: vividc.KernelFunction) -> None:
    """Though a row might be shorter, for all that the addresses say."""
    assert bounds_of_loop(kernel).get("RecMII", 1) == 1


def test_rows_that_overlap_in_flat_indices_stay_in_order() -> None:
    """x[i * n + 5] is legal for n < 5, and then meets what a later iteration reads."""
    program = vividc.compile(k.overlapping_rows, MACHINE)
    for n in (1, 2, 3, 5, 6):
        x = np.arange(100, 160, dtype=np.int32)
        expected = x.copy()
        assert vividc.simulate(program, x, n).value == k.overlapping_rows(expected, n)
        assert np.array_equal(x, expected)


def check(kernel: vividc.KernelFunction, *args: object) -> None:
    """The simulator against numba."""
    program = vividc.compile(kernel, MACHINE, time_limit_s=60.0, effort="fast")
    expected, actual = copy.deepcopy(args), copy.deepcopy(args)
    assert vividc.simulate(program, *actual).value == kernel(*expected)
    for one, other in zip(expected, actual, strict=True):
        assert np.array_equal(one, other)


def test_columns_and_planes() -> None:
    a = np.arange(12, dtype=np.int32).reshape(4, 3)
    check(k.columns, a, a[::-1].copy())
    check(k.planes, np.arange(27, dtype=np.int32).reshape(3, 3, 3))
    check(k.others, a, np.arange(9, dtype=np.int32), 1)


@pytest.mark.parametrize("seed", [0, 1])
def test_random_programs(load: Load, seed: int) -> None:  # noqa: F811 - the fixture
    check(load(k.random_program(seed), "program"), *k.arguments(seed))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 200))
def test_many_random_programs(load: Load, seed: int) -> None:  # noqa: F811 - the fixture
    check(load(k.random_program(seed), "program"), *k.arguments(seed))
