"""Kernels that once failed: the array leaves what numba leaves, integers bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.e2e import found_kernels as k


def assert_agrees(kernel: vividc.KernelFunction, fabric: str, *args: object) -> None:
    """Simulates and runs numba on copies of the same arguments."""
    program = vividc.compile(kernel, fabric=fabric)
    mine = [a.copy() if isinstance(a, np.ndarray) else a for a in args]
    theirs = [a.copy() if isinstance(a, np.ndarray) else a for a in args]
    assert vividc.simulate(program, *mine).value == kernel(*theirs)
    for array, expected in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(array, expected)


def words(length: int) -> np.ndarray:
    return np.random.default_rng(length).integers(-9, 9, length, dtype=np.int32)


@pytest.mark.parametrize("fabric", ["vivid-tile", "mesh-2x2"])
@pytest.mark.parametrize("n", [-1, 5])
def test_a_branch_may_lead_straight_to_the_end(fabric: str, n: int) -> None:
    assert_agrees(k.return_early, fabric, words(3), n)


@pytest.mark.parametrize("length", [0, 1, 2, 7, 8191, 8192])
@pytest.mark.parametrize("kernel", [k.count_up, k.step_down, k.step_up, k.find_back])
def test_the_exiting_iteration_may_look_beside_its_array(
    kernel: vividc.KernelFunction, length: int
) -> None:
    """The loop's own test guards the load, which runs before the test is known."""
    assert_agrees(kernel, "vivid-tile", words(length))


@pytest.mark.parametrize("length", [0, 1, 2, 30])
def test_insertion_sort(length: int) -> None:
    assert_agrees(k.insertion_sort, "vivid-tile", words(length))


def test_a_store_beside_its_array_is_an_error_and_nothing_is_written() -> None:
    array = np.zeros(4, np.int32)
    with pytest.raises(vividc.VividcError, match="array a, which has 16") as caught:
        vividc.simulate(vividc.compile(k.fill), array, 8)
    assert "a[i] = 99" in str(caught.value)
    assert not array.any()


def test_a_load_beside_its_array_is_an_error_only_if_its_iteration_counts() -> None:
    program = vividc.compile(k.sum_until)
    b = np.arange(10, dtype=np.int32)
    assert vividc.simulate(program, np.array([1, 1, -1], np.int32), b).value == 1
    with pytest.raises(vividc.VividcError, match="array a, which has 12"):
        vividc.simulate(program, np.array([1, 1, 1], np.int32), b)


@pytest.mark.parametrize("kernel", [k.huge_literal, k.tiny_literal])
def test_a_literal_outside_float32_is_refused(kernel: vividc.KernelFunction) -> None:
    with pytest.raises(vividc.VividcError, match="does not fit float32"):
        vividc.compile(kernel)


def test_a_numpy_function_that_numba_cannot_link_is_refused_with_its_line() -> None:
    with pytest.raises(vividc.VividcError, match=r"found_kernels.py:\d+"):
        vividc.compile(k.numpy_dot)
