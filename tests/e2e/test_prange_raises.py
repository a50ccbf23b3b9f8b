"""Loops over `prange` whose iterations may raise: rows that are unpacked, slices that must be of
one size, a user's own exceptions.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import SimulationError
from vividc.launch import Spread, SpreadOptions, spread
from vividc.ssa.parallel.cut import cut_parallel_loop

ROWS = "float32[:, ::1]"


@vividc.kernel(f"void({ROWS}, float32[::1])")
def unpacked(d, out):
    for i in prange(d.shape[0]):
        a, b, c = d[i]
        out[i] = a * b + c


@vividc.kernel(f"void({ROWS}, {ROWS}, float32[::1])")
def products(d, e, out):
    for i in prange(d.shape[0]):
        out[i] = np.dot(d[i], e[i])


@vividc.kernel(f"void({ROWS}, {ROWS}, {ROWS})")
def all_products(d, e, out):
    for i in prange(d.shape[0]):
        for j in range(e.shape[0]):
            out[i, j] = np.dot(d[i], e[j])


@vividc.kernel(f"void({ROWS}, {ROWS}, {ROWS})")
def unit_vectors(d, e, out):
    for i in prange(d.shape[0]):
        v = d[i] - e[i]
        out[i] = v / np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@vividc.kernel(f"void({ROWS}, {ROWS})")
def filled_rows(d, out):
    for i in prange(d.shape[0]):
        v = np.zeros(3, np.float32)
        for k in range(3):
            v[k] = d[i, k] * np.float32(2)
        out[i, :] = v


@vividc.kernel("float32(float32[::1], float32[::1])")
def checked(x, y):
    if len(x) != len(y):
        raise ValueError("lengths differ")
    total = np.float32(0)
    for i in prange(len(x)):
        if x[i] < np.float32(0):
            raise ValueError("negative")
        if x[i] > np.float32(50):
            raise IndexError("too large")
        y[i] = x[i] + np.float32(1)
        total = max(total, y[i])
    return total


D = np.random.default_rng(1).random((67, 3)).astype(np.float32)
E = np.random.default_rng(2).random((67, 3)).astype(np.float32)
LINE = np.arange(67, dtype=np.float32) / 2


def launched(kernel: Any, args: tuple[Any, ...], chunk: int | None = None) -> Spread:
    function, parallel = cut_parallel_loop(kernel.lower(spread=True), kernel.prange_lines)
    program = replace(words_in_blocks(function), parallel=parallel)
    return spread(program, args, {}, "vivid", SpreadOptions(chunk=chunk))


@pytest.mark.parametrize(
    ("kernel", "args"),
    [
        (unpacked, (D, np.zeros(67, np.float32))),
        (products, (D, E, np.zeros(67, np.float32))),
        (all_products, (D, E, np.zeros((67, 67), np.float32))),
        (unit_vectors, (D, E, np.zeros((67, 3), np.float32))),
        (filled_rows, (D, np.zeros((67, 3), np.float32))),
        (checked, (LINE, np.zeros(67, np.float32))),
    ],
)
def test_what_raises_nothing_is_spread(kernel: Any, args: tuple[Any, ...]) -> None:
    mine, theirs = [a.copy() for a in args], [a.copy() for a in args]
    made = launched(kernel, tuple(mine))
    assert len(made.plan.chunks) > 16
    assert made.simulate().value == kernel(*theirs)
    for one, other in zip(mine, theirs, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)


@pytest.mark.parametrize("chunk", [None, 2, 1000])
def test_the_first_exception_in_the_order_of_iterations_is_raised(chunk: int | None) -> None:
    x = LINE.copy()
    x[[20, 21, 50]] = [60, -1, -1]
    with pytest.raises(IndexError, match="too large"):
        launched(checked, (x, np.zeros(67, np.float32)), chunk).simulate()
    x[[7, 8]] = [-1, 60]
    with pytest.raises(ValueError, match="negative"):
        launched(checked, (x, np.zeros(67, np.float32)), chunk).simulate()


def test_an_exception_before_the_loop_is_raised_once() -> None:
    y = np.full(66, 7, np.float32)
    with pytest.raises(ValueError, match="lengths differ"):
        launched(checked, (LINE, y)).simulate()
    assert (y == 7).all()


def test_rows_of_another_size_raise() -> None:
    with pytest.raises(ValueError, match=r":\d+: ValueError\n"):
        launched(unpacked, (np.ones((67, 2), np.float32), np.zeros(67, np.float32))).simulate()
    with pytest.raises(SimulationError, match="ValueError"):
        launched(products, (D, E[:, :2].copy(), np.zeros(67, np.float32))).simulate()
