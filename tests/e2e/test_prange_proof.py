"""A loop over `prange` is spread where that is proved to be what one tile computes, and runs on one
tile with a warning where it is not.
"""

from __future__ import annotations

import warnings
from typing import Any

import numba
import numpy as np
import pytest
from numba import prange

import vividc
from vividc.errors import KernelError, VividcWarning
from vividc.ssa.parallel.cut import cut_parallel_loop


@vividc.kernel("float32(float32[::1])")
def read_after(y):
    t = np.zeros(len(y), np.float32)
    for i in prange(len(y)):
        t[i] = y[i]
    return t[0] + t[len(y) - 1]


@vividc.kernel("void(int32[::1], int32[::1])")
def counts(x, y):
    t = np.zeros(8, np.int32)
    for i in prange(len(x)):
        y[i] = t[x[i] & 7]
        t[x[i] & 7] += 1


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def entered_again(x, y, n):
    t = np.zeros(40, np.int32)
    for s in range(n):
        for i in prange(len(x)):
            y[i] += t[len(x) - 1 - i]
            t[i] = x[i] + s


@vividc.kernel("void(int32[::1], int32[::1])")
def kept_by_an_empty_array(x, y):
    t = np.empty(1, np.int32)
    for i in prange(len(x)):
        if i == 0:
            t[0] = x[0]
        y[i] = t[0]


@vividc.kernel("void(int32[::1], int32[::1])")
def own_element(x, y):
    t = np.zeros(len(x), np.int32)
    for i in prange(len(x)):
        t[i] = 3 * x[i]
        y[i] = t[i] + 1


@vividc.kernel("void(int32[::1], int32[::1])")
def table_before(x, y):
    t = np.zeros(8, np.int32)
    for k in range(8):
        t[k] = k * x[0]
    for i in prange(len(x)):
        y[i] = t[x[i] & 7]


@vividc.kernel("void(int32[::1], int32[::1])")
def made_inside(x, y):
    for i in prange(len(x)):
        t = np.zeros(4, np.int32)
        t[x[i] & 3] += x[i]
        y[i] = t[i & 3]


@vividc.kernel("void(int32[::1], int32, int32)")
def in_an_if(y, n, m):
    if m > 3:
        for i in prange(n):
            y[i] = 1


@vividc.kernel("void(int32[::1], int32, int32)")
def after_a_return(y, n, m):
    if m <= 3:
        return
    for i in prange(n):
        y[i] = 1


@vividc.kernel("void(int32[::1], int32, int32)")
def in_a_loop(y, n, m):
    for _k in range(m - 3):
        for i in prange(n):
            y[i] = 1


@vividc.kernel("int32(int32[::1], int32, int32)")
def sum_in_an_if(x, n, m):
    s = 3
    if m > 3:
        for i in prange(n):
            s += x[i]
    return s


@vividc.kernel("int32(int32[::1], int32, int32)")
def sum_after_a_return(x, n, m):
    if m <= 3:
        return 7
    s = 3
    for i in prange(n):
        s += x[i]
    return s


@vividc.kernel("int32(int32[::1], int32, int32)")
def sum_of_sums(x, n, m):
    s = 3
    for _k in range(m):
        for i in prange(n):
            s += x[i]
    return s


@vividc.kernel("void(int32[::1], int32, int32)")
def bound_of_a_counter(y, n, m):
    for k in range(m):
        for i in prange(k):
            y[i] += n


@vividc.kernel("void(int32[::1], int32, int32)")
def bound_of_a_quotient(y, n, m):
    for i in prange(n // 3):
        y[i] += m


@vividc.kernel("void(int32[::1], int32, int32)")
def bound_of_a_quotient_of_two(y, n, m):
    if m > 0:
        for i in prange(n // m):
            y[i] += m


@vividc.kernel("void(int32[::1], int32, int32)")
def in_a_while(y, n, m):
    while m > 0:
        for i in prange(n):
            y[i] += 1
        m -= 1


@vividc.kernel("int32(int32[::1], int32, int32)")
def store_outside(y, n, m):
    y[0] = m
    for i in prange(1, n):
        y[i] += 1
    return y[n - 1]


@vividc.kernel("void(int32[::1], int32[::1])")
def histogram_of_its_own(x, y):
    h = np.zeros(8, np.int32)
    for i in prange(len(x)):
        h[x[i] & 7] += 1
    for j in range(8):
        y[j] = h[j]


@vividc.kernel("boolean(int32[::1])")
def flag(x):
    seen = np.zeros(1, np.bool_)
    for i in prange(len(x)):
        if x[i] == 33:
            seen[0] = True
    return seen[0]


@vividc.kernel("int32(int32[::1])")
def last_value(x):
    s = np.int32(0)
    for i in prange(len(x)):
        s = x[i]
    return s


@vividc.kernel("int32(int32[::1])")
def last_index(x):
    i = np.int32(0)
    for j in prange(len(x)):
        x[j] += 1
        i = np.int32(j)
    return i


@vividc.kernel("void(int8[::1], int8[::1])")
def bytes_at_borders(x, y):
    for i in prange(1, len(x) - 1):
        if x[i] % 3:
            y[i] = x[i]


@vividc.kernel("void(boolean[::1], int32[::1])")
def flags_at_borders(y, x):
    for i in prange(len(x)):
        y[i] = x[i] % 5 == 0


@vividc.kernel("void(uint8[::1], int32[::1])")
def bytes_backwards(y, x):
    for i in prange(len(x)):
        y[300 - i] = x[i] & 255


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def gather(p, x, y):
    for i in prange(len(p)):
        y[i] = x[p[i]]


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def scatter(p, x, y):
    for i in prange(len(p)):
        y[p[i]] = x[i]


@vividc.kernel("void(int16[:, ::1], int16[:, ::1])")
def rows_of_halves(x, y):
    for i in prange(64):
        for j in range(9):
            y[i, j] = x[63 - i, j + 1]


@vividc.kernel("float32(float32[::1])")
def least_with_the_element_first(x):
    s = np.float32(9)
    for i in prange(len(x)):
        s = min(x[i], s)
    return s


@vividc.kernel("float32(float32[::1])")
def least_with_the_variable_first(x):
    s = np.float32(9)
    for i in prange(len(x)):
        s = min(s, x[i])
    return s


@numba.njit
def thrice(x, y):
    for i in prange(len(x)):
        y[i] = 3 * x[i]


@vividc.kernel("void(int32[::1], int32[::1])")
def in_a_function_that_it_calls(x, y):
    thrice(x, y)


@vividc.kernel("void(int32[::1], int32[::1])")
def every_second(x, y):
    for i in prange(0, len(x), 2):
        y[i] = x[i]


X = np.arange(3, 43, dtype=np.int32)
REALS = np.arange(40, 0, -1, dtype=np.float32)
NANS = np.where(REALS % 7 == 3, np.float32(np.nan), REALS)
PAIR = (X, np.full(40, 9, np.int32))
TWO = ((X, 40, 2), (X, 40, 5))
PLACES = np.arange(40, dtype=np.int32)[::-1].copy()
BYTES = np.arange(101, dtype=np.int8)
LONG = np.arange(300, dtype=np.int32)
HALVES = np.arange(640, dtype=np.int16).reshape(64, 10)
CASES: list[tuple[Any, bool, tuple[tuple[Any, ...], ...]]] = [
    (read_after, False, ((np.arange(1, 33, dtype=np.float32),),)),
    (counts, False, (PAIR,)),
    (entered_again, False, ((*PAIR, 3),)),
    (kept_by_an_empty_array, False, (PAIR,)),
    (own_element, True, (PAIR,)),
    (table_before, True, (PAIR,)),
    (made_inside, True, (PAIR,)),
    (in_an_if, True, TWO),
    (after_a_return, True, TWO),
    (in_a_loop, True, TWO),
    (sum_in_an_if, False, TWO),
    (sum_after_a_return, False, TWO),
    (sum_of_sums, False, TWO),
    (bound_of_a_counter, False, TWO),
    (bound_of_a_quotient, True, TWO),
    (bound_of_a_quotient_of_two, True, ((X, 40, 0), (X, 40, 2))),
    (in_a_while, True, TWO),
    (store_outside, False, TWO),
    (histogram_of_its_own, False, (PAIR,)),
    (flag, False, ((X,), (X + 40,))),
    (last_value, False, ((X,),)),
    (last_index, False, ((X,),)),
    (bytes_at_borders, True, ((BYTES, np.ones(101, np.int8)),)),
    (flags_at_borders, True, ((np.ones(101, np.bool_), LONG[:101]),)),
    (bytes_backwards, True, ((np.full(301, 5, np.uint8), LONG),)),
    (gather, True, ((PLACES, X, np.zeros(40, np.int32)),)),
    (scatter, False, ((PLACES, X, np.zeros(40, np.int32)),)),
    (least_with_the_element_first, False, ((REALS,), (NANS,))),
    (least_with_the_variable_first, True, ((REALS,), (NANS,))),
    (in_a_function_that_it_calls, False, (PAIR,)),
    (every_second, False, (PAIR,)),
    (rows_of_halves, True, ((HALVES, np.zeros((64, 10), np.int16)),)),
]


@pytest.mark.parametrize(
    ("kernel", "is_spread", "launches"), CASES, ids=lambda x: getattr(x, "name", "")
)
def test_all_tiles_do_what_numba_does(kernel: Any, is_spread: bool, launches: Any) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        program = vividc.compile(
            kernel,
            fabric="vivid",
            loops=vividc.LoopOptions(auto=False),
            effort="fast",
            time_limit_s=6,
        )
        for args in launches:
            expected, got = (
                [a.copy() if isinstance(a, np.ndarray) else a for a in args] for _ in range(2)
            )
            value = kernel(*expected)
            result = vividc.simulate(program, *got, fabric="vivid")
            assert result.value == value
            for one, other in zip(expected, got, strict=True):
                np.testing.assert_array_equal(other, one)
            assert (len(result.stats["tiles"]) > 1) is (is_spread and result.stats["runs"] > 1)
    lines = [str(w.message) for w in told if issubclass(w.category, VividcWarning)]
    assert any("runs on one tile only" in text for text in lines) is not is_spread
    assert all("test_prange_proof.py:" in text for text in lines)


@vividc.kernel("void(int32[::1], int32[::1])")
def scan(x, y):
    total = np.int32(0)
    for i in prange(len(x)):
        total += x[i]
        y[i] = total


@vividc.kernel("int32(int32[::1])")
def reset(x):
    total = np.int32(0)
    for i in prange(len(x)):
        total += x[i]
        if x[i] == 0:
            total = np.int32(0)
    return total


@vividc.kernel("int64(int32[::1])")
def doubling(x):
    total = 1
    for i in prange(len(x)):
        total += total + x[i]
    return total


@vividc.kernel("int64(int32[::1])")
def wide_scan(x):
    total = 0
    for i in prange(len(x)):
        total += x[i]
        x[i] = total
    return total


@vividc.kernel("float32(float32[::1])")
def mean(x):
    total = np.float32(0)
    for i in prange(len(x)):
        total += x[i]
    return total / np.float32(len(x))


@vividc.kernel("void(int32[::1], int32[::1])")
def early(x, y):
    for i in prange(len(x)):
        if x[i] < 0:
            break
        y[i] = x[i]


@vividc.kernel("void(int32[::1], int32[::1])")
def two_loops(x, y):
    for i in prange(len(x)):
        y[i] = x[i] * x[i] * x[i] + 2 * x[i] * i
    last = np.int32(0)
    for i in prange(len(x)):
        y[i] += last
        last = x[i]


@vividc.kernel("void(int32[::1], int32[::1])")
def unknown_bound(x, y):
    for i in prange(x[0]):
        y[i] = 1


@pytest.mark.parametrize(
    ("kernel", "says"),
    [
        (scan, "what an earlier one computed"),
        (reset, "what an earlier one computed"),
        (doubling, "what an earlier one computed"),
        (wide_scan, "what an earlier one computed"),
        (mean, "used after it"),
        (early, "left early"),
        (two_loops, "a second loop over prange"),
        (every_second, "does not count up by one"),
        (unknown_bound, "computed from the kernel's arguments"),
        (least_with_the_element_first, r"variable first, min\(s, x\[i\]\)"),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_what_cannot_be_spread_is_told_with_its_line(kernel: Any, says: str) -> None:
    function, parallel = kernel.lower(spread=True), kernel.prange_lines
    with pytest.raises(KernelError, match=says) as error:
        cut_parallel_loop(function, parallel)
    assert "test_prange_proof.py:" in str(error.value)
    assert error.value.hint
