"""Kernels that once failed: the array leaves what numba leaves, integers bit for bit."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from tests.e2e import found_kernels as k
from vividc.program import Program


@cache
def compiled(kernel: vividc.KernelFunction, fabric: str) -> Program:
    """Once for all arguments."""
    return vividc.compile(kernel, fabric=fabric, effort="fast")


def assert_agrees(kernel: vividc.KernelFunction, fabric: str, *args: object) -> None:
    """Simulates and runs numba on copies of the same arguments."""
    program = compiled(kernel, fabric)
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
        vividc.compile(k.euclidean_norm)


@pytest.mark.parametrize("values", [[1, 2, 20, 3], [1, 2, 3], []])
def test_a_value_of_the_body_returned_from_a_counted_loop(values: list[int]) -> None:
    array = np.array(values, np.int32)
    assert_agrees(k.return_from_loop, "mesh-2x2", array, np.int32(len(values)))


def test_a_select_between_signed_zeros_is_kept() -> None:
    """Bit for bit: 0.0 == -0.0 hides the difference."""
    a = np.arange(6, dtype=np.int32)
    mine, theirs = np.ones(6, np.float32), np.ones(6, np.float32)
    vividc.simulate(vividc.compile(k.signed_zeros), a, mine)
    k.signed_zeros(a, theirs)
    np.testing.assert_array_equal(mine.view(np.uint32), theirs.view(np.uint32))


@pytest.mark.parametrize("start", [2**31 - 4, 2**31 - 5, 0])
def test_a_counter_that_wraps(start: int) -> None:
    n = 2**31 - 1 if start else 20
    assert_agrees(k.wrapping_counter, "vivid-tile", words(16), np.int32(start), np.int32(n))


def test_a_float_to_a_wide_integer_is_warned_of_and_refused_when_strict() -> None:
    with pytest.warns(vividc.VividcWarning, match="saturates at 32 bits"):
        vividc.compile(k.low_byte)
    with pytest.raises(vividc.VividcError, match="64-bit integer"):
        vividc.compile(k.low_byte, strict_fp=True)


def test_an_index_is_a_word() -> None:
    """Its sum needs 33 bits, or its product 64, only where it is outside the array."""
    assert_agrees(k.shifted, "vivid-tile", words(30), words(20), np.int32(-5), np.int32(20))
    out = np.zeros(96, np.float32)
    assert_agrees(k.flat_index, "vivid-tile", out, np.int32(6), np.int32(4))


@pytest.mark.parametrize("threshold", [0, 7, -3, 2**31 - 1, -(2**31)])
def test_comparisons_of_sums_take_two_words(threshold: int) -> None:
    ends = [0, 1, -1, 2**31 - 1, -(2**31), 2**30, -(2**30), 5, 7, 2**31 - 2]
    a = np.repeat(np.array(ends, np.int32), len(ends))
    b = np.tile(np.array(ends, np.int32), len(ends))
    assert_agrees(k.compare_sums, "vivid-tile", a, b, np.int32(threshold))


@pytest.mark.parametrize("n", [-(2**31), -5, 0, 1, 3, 4, 40])
def test_a_step_that_may_carry_the_counter_past_a_word(n: int) -> None:
    assert_agrees(k.every_third, "vivid-tile", np.zeros(40, np.int32), np.int32(n), np.int32(2))


@pytest.mark.parametrize("n", [-(2**31), -(2**31) + 3, -5, 0, 1, 5, 37])
def test_counters_that_start_outside_a_word(n: int) -> None:
    array = np.zeros(40, np.int32)
    assert_agrees(k.counters_of_two_words, "vivid-tile", array, np.int32(n), np.int32(2))


@pytest.mark.parametrize("limit", [-(2**31), 0, 2**31 - 2, 2**31 - 1])
def test_a_sum_that_outgrows_a_word_is_compared_in_two(limit: int) -> None:
    for values in ([2**31 - 1, 1, 5], [-(2**31), -(2**31), 7], [2**31 - 1] * 6, [0, -1]):
        array = np.array(values, np.int32)
        assert_agrees(k.accumulate_wide, "vivid-tile", array, np.int32(limit))


def test_extrema_and_shifts_of_sums_take_two_words() -> None:
    ends = [0, 1, -1, 2**31 - 1, -(2**31), 2**30, -(2**30), 5, 7, 2**31 - 2]
    a = np.repeat(np.array(ends, np.int32), len(ends))
    b = np.tile(np.array(ends, np.int32), len(ends))
    assert_agrees(k.extrema_of_sums, "vivid-tile", a, b, words(len(a)))


@pytest.mark.parametrize("value", [6, 7, 0, -8])
def test_the_lowest_bit_of_a_word_is_no_neutral_and(value: int) -> None:
    """Simplification after unrolling took `and` of a word with 1 for one of a predicate."""
    u, x = np.arange(16, dtype=np.uint32), np.full(2, value, np.int32)
    assert_agrees(k.product_with_lowest_bit, "vivid-tile", u, x)
