"""Operations and floors of kernels, counted by running their text."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from benchmarks.polybench.suite import CASES, MINI
from benchmarks.polybench.trace import Trace, paths, traced
from vividc.machine.opcodes import Opcode

ONE, TWO = np.float32(1.0), np.float32(2.0)
ADD = MUL = FMA = 4
INT = 1


@vividc.kernel("void(float32, float32[::1], float32[::1])")
def chain(scale, x, out):
    total = np.float32(0.0)
    for i in range(len(x)):
        total += scale * x[i]
    out[0] = total


@vividc.kernel("void(float32[::1], float32[::1])")
def difference(x, out):
    out[0] = x[0] - x[1] * x[2]
    out[1] = ONE - x[1] * x[1]


@vividc.kernel("void(float32[::1], float32[::1])")
def product_used_twice(x, out):
    product = x[0] * x[1]
    out[0] = product
    out[1] = product + x[2]


@vividc.kernel("void(float32[::1], float32[::1])")
def sum_of_products(x, out):
    early, late = x[0] * x[1], (x[2] + x[3]) * x[4]
    out[0] = early + late


@vividc.kernel("void(float32, float32[::1], float32[:, ::1])")
def scaled_rows(alpha, x, out):
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] += alpha * x[i] * x[j]


@vividc.kernel("void(float32[::1], float32[::1])")
def stored_between(x, out):
    out[0] = x[0] + x[1]
    out[1] = x[0] + x[1]
    x[0] = x[0]
    out[2] = x[0] + x[1]


@vividc.kernel("void(float32[::1], float32[::1])")
def quotients(x, out):
    y = x[0]
    for _ in range(3):
        y = y / x[1]
    out[0] = y
    out[1] = x[0] / (x[1] + x[2])


@vividc.kernel("void(int32[::1], int32[::1])")
def least(x, out):
    i = 2 * len(x) - 5  # index arithmetic
    out[i % 2] = min(x[0] + x[1], x[2])
    if x[0] < x[1]:
        out[0] = 1


def floats(*numbers: float) -> np.ndarray:
    return np.array(numbers, np.float32)


def trace_of(kernel: vividc.KernelFunction, *arguments: object) -> Trace:
    return traced(kernel, arguments)


def test_a_sum_takes_its_products_one_after_the_other() -> None:
    trace = trace_of(chain, TWO, np.ones(10, np.float32), np.zeros(1, np.float32))
    assert (trace.operations, trace.floor) == (10, 10 * FMA)


def test_a_difference_takes_a_product() -> None:
    trace = trace_of(difference, floats(1, 2, 3), floats(0, 0))
    assert (trace.operations, trace.floor) == (2, FMA)


def test_a_product_that_is_stored_counts() -> None:
    trace = trace_of(product_used_twice, floats(1, 2, 3), floats(0, 0))
    assert trace.operations == 2


def test_of_two_products_the_sum_takes_the_later() -> None:
    trace = trace_of(sum_of_products, floats(1, 2, 3, 4, 5), floats(0))
    assert (trace.operations, trace.floor) == (3, ADD + FMA)


def test_what_does_not_change_counts_once() -> None:
    trace = trace_of(scaled_rows, TWO, floats(1, 2, 3), np.ones((3, 3), np.float32))
    assert (trace.operations, trace.floor) == (3 + 9, MUL + FMA)


def test_an_element_that_is_stored_is_another() -> None:
    assert trace_of(stored_between, floats(1, 2), floats(0, 0, 0)).operations == 2


def test_a_division_waits_for_each_operand_by_its_own_path() -> None:
    dividend, divisor = paths(Opcode.FDIV)
    assert dividend < divisor
    trace = trace_of(quotients, floats(1, 2, 3), floats(0, 0))
    assert trace.operations == 3 + 2
    assert trace.floor == max(divisor + 2 * dividend, ADD + divisor)


def test_integers_count_and_indices_do_not() -> None:
    x, out = np.array([3, 4, 5], np.int32), np.zeros(2, np.int32)
    trace = trace_of(least, x, out)
    assert trace.operations == 3  # the sum, the minimum, the comparison
    assert trace.floor == 2 * INT


def test_arguments_stay_as_they_are() -> None:
    out = floats(0)
    trace_of(chain, TWO, floats(1, 2), out)
    assert out[0] == 0.0


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.operations])
def test_closed_forms_are_what_is_counted(name: str) -> None:
    case = CASES[name]
    assert case.operations is not None
    expected = case.operations(*case.sizes[MINI])
    assert traced(case.kernel, case.fresh(MINI)).operations == expected


@pytest.mark.parametrize("name", ["seidel-2d", "durbin", "nussinov"])
def test_a_run_on_counting_numbers_takes_the_kernels_way(name: str) -> None:
    """Durbin's operations in closed form; those of the others are fewer than their text has."""
    counts = {"seidel-2d": 2 * 9 * 8 * 8, "durbin": 14 * 13 + 13 * 5, "nussinov": 12 * 11 // 2 * 20}
    case = CASES[name]
    found = traced(case.kernel, case.fresh(MINI)).operations
    assert 0.5 * counts[name] < found <= counts[name]
