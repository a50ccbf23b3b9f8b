"""What fills an array before a loop over `prange`, and what goes on with it behind, is shared among
the tiles like the loop.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import VividcWarning
from vividc.launch import Spread, SpreadOptions, spread
from vividc.ssa.parallel.cut import cut_parallel_loop

Kernel = Any


@vividc.kernel("float32[:, :, ::1](int32, int32)")
def channels(h, w):
    image = np.zeros((h, w, 3), np.float32)
    for y in prange(h):
        for x in range(w):
            image[y, x, 0] = np.float32(x)
            image[y, x, 2] = np.float32(y)
    return image


@vividc.kernel("float32[:, :, ::1](int32, int32)")
def overwritten(h, w):
    image = np.zeros((h, w, 3), np.float32)
    for y in prange(h):
        for x in range(w):
            image[y, x, 0] = np.float32(x)
            image[y, x, 1] = np.float32(0.5)
            image[y, x, 2] = np.float32(y)
    return image


@vividc.kernel("int32[:, ::1](int32[:, ::1], int32)")
def accumulated(m, n):
    image = np.zeros_like(m)
    for y in prange(m.shape[0]):
        for k in range(n):
            for x in range(m.shape[1]):
                image[y, x] += k * m[y, x]
    return image


@vividc.kernel("Tuple((float32[:, ::1], float32[:, ::1]))(float32[:, ::1])")
def two_returned(m):
    image = np.full(m.shape, np.float32(3))
    depth = np.ones(m.shape, np.float32)
    for y in prange(m.shape[0]):
        for x in range(m.shape[1]):
            if m[y, x] > np.float32(0.5):
                image[y, x] = m[y, x] * np.float32(2)
                depth[y, x] = m[y, x]
    return image, depth


@vividc.kernel("float32[:, ::1](float32[:, ::1], float32)")
def copied_and_scaled(m, by):
    out = m.copy()
    for y in prange(1, m.shape[0] - 1):
        for x in range(1, m.shape[1] - 1):
            out[y, x] = m[y - 1, x] + m[y + 1, x]
    return out * by


@vividc.kernel("int32[::1](int32[::1])")
def two_loops(x):
    once = np.empty(len(x), np.int32)
    twice = np.empty(len(x), np.int32)
    for i in prange(len(x)):
        once[i] = x[i] * 3
    for i in prange(len(x)):
        twice[i] = once[i] + 1
    return twice


@vividc.kernel("int32[::1](int32[:, ::1], int32)")
def running_sums(m, n):
    square = np.empty(m.shape, np.int32)
    sums = np.zeros(m.shape[0], np.int32)
    for y in prange(m.shape[0]):
        for x in range(m.shape[1]):
            square[y, x] = m[y, x] * m[y, x]
    for k in range(n):
        for y in prange(m.shape[0]):
            for x in range(m.shape[1]):
                sums[y] += square[y, x] >> k
    return (sums + 1).astype(np.int32)


@vividc.kernel("Tuple((int32[:, ::1], int32[:, ::1]))(int32[:, ::1], int32[:, ::1], int32[::1])")
def shapes_at_launch(pos, vel, told):
    moved = np.zeros_like(pos)
    for i in prange(pos.shape[0]):
        for k in range(pos.shape[1]):
            moved[i, k] += pos[i, k] * 3
    told[1] = pos.shape[0]
    return (vel + moved).astype(np.int32), (pos - vel).astype(np.int32)


@vividc.kernel("int32[:, ::1](int32[:, ::1], int32, int32)")
def windows(m, first, less):
    out = np.zeros_like(m)
    for y in prange(m.shape[0]):
        for x in range(first, m.shape[1] - less):
            out[y, x] = m[y, x] + x
    return out


@vividc.kernel("int32[::1](int32[::1])")
def neighbours(x):
    once = np.zeros(len(x), np.int32)
    for i in prange(len(x)):
        once[i] = x[i] * 3
    for i in range(1, len(x)):
        once[i] += once[i - 1]
    return once


@vividc.kernel("int32[::1](int32[::1])")
def read_by_all(x):
    table = np.zeros(len(x), np.int32)
    for i in range(len(x)):
        table[i] = x[i] + 1
    for i in prange(len(x)):
        x[i] = table[x[i] & 7]
    return table


IMAGE = np.random.default_rng(3).random((71, 23)).astype(np.float32)
NUMBERS = np.random.default_rng(4).integers(0, 99, (71, 23)).astype(np.int32)
LONG = np.random.default_rng(5).integers(0, 99, 333).astype(np.int32)


def launched(kernel: Kernel, args: tuple[Any, ...], chunk: int | None = None) -> Spread:
    function, parallel = cut_parallel_loop(kernel.lower(spread=True), kernel.prange_lines)
    program = replace(words_in_blocks(function), parallel=parallel)
    return spread(program, args, {}, "vivid", SpreadOptions(chunk=chunk))


@pytest.mark.parametrize("chunk", [None, 5, 1000])
@pytest.mark.parametrize(
    ("kernel", "args"),
    [
        (channels, (53, 17)),
        (channels, (0, 4)),
        (overwritten, (53, 17)),
        (accumulated, (NUMBERS, 3)),
        (two_returned, (IMAGE,)),
        (copied_and_scaled, (IMAGE, np.float32(0.25))),
        (running_sums, (NUMBERS, 4)),
        (two_loops, (LONG,)),
    ],
)
def test_spread_as_numba_computes(kernel: Kernel, args: tuple[Any, ...], chunk: int | None) -> None:
    made = launched(kernel, args, chunk)
    assert (len(made.plan.chunks) > 1) is (chunk != 1000 and len(_rows(args)) > 0)
    for one, other in zip(_all(made.simulate().value), _all(kernel(*args)), strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_all_chunks_store_alike_is_stored_once() -> None:
    mine, theirs = np.arange(4, dtype=np.int32), np.arange(4, dtype=np.int32)
    made = launched(shapes_at_launch, (NUMBERS, NUMBERS + 1, mine))
    assert len(made.plan.chunks) > 1
    found, wanted = made.simulate().value, shapes_at_launch(NUMBERS, NUMBERS + 1, theirs)
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one, other)
    assert mine.tolist() == theirs.tolist() == [0, 71, 2, 3]


@pytest.mark.parametrize(
    ("first", "less", "is_spread"),
    [(2, 3, True), (-2, 2, False), (0, 0, True), (40, 9, True), (3, 2**31 - 1, True)],
)
def test_columns_between_sums_of_64_bits(first: int, less: int, is_spread: bool) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        made = launched(windows, (NUMBERS, first, less))
    assert (len(made.plan.chunks) > 1) is is_spread
    np.testing.assert_array_equal(made.simulate().value, windows(NUMBERS, first, less))


def test_an_array_larger_than_a_scratchpad() -> None:
    made = launched(channels, (37, 201))
    np.testing.assert_array_equal(made.simulate().value, channels(37, 201))


def _rows(args: tuple[Any, ...]) -> range:
    return range(args[0] if isinstance(args[0], int) else len(args[0]))


def _all(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


@pytest.mark.parametrize(("kernel", "args"), [(neighbours, (LONG,)), (read_by_all, (LONG,))])
def test_what_chunks_would_need_of_each_other_stays_on_one_tile(
    kernel: Kernel, args: tuple[Any, ...]
) -> None:
    mine, theirs = [a.copy() for a in args], [a.copy() for a in args]
    with pytest.warns(VividcWarning, match="one tile only"):
        made = launched(kernel, tuple(mine))
    assert len(made.plan.chunks) == 1
    np.testing.assert_array_equal(made.simulate().value, kernel(*theirs))
    np.testing.assert_array_equal(mine[0], theirs[0])


def test_a_slice_that_is_filled_is_not_moved_in() -> None:
    for kernel, args in ((channels, (53, 17)), (accumulated, (NUMBERS, 3))):
        assert all("return" in one.overwritten for one in launched(kernel, args).plan.chunks)


def test_what_the_loop_writes_anyway_is_not_filled() -> None:
    words = [one.words for one in launched(overwritten, (53, 17)).plan.chunks]
    assert all(one["prange.beside.first0"] == one["prange.beside.last0"] for one in words)
    words = [one.words for one in launched(channels, (53, 17)).plan.chunks]
    assert sum(one["prange.beside.last0"] - one["prange.beside.first0"] for one in words) == (
        53 * 17 * 3
    )


def test_a_program_spreads_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", VividcWarning)
        program = vividc.compile(two_loops, fabric="vivid", effort="fast")
        result = vividc.simulate(program, LONG)
    assert sum(event.kind == "run" for event in result.events) > 16
    np.testing.assert_array_equal(result.value, two_loops(LONG))
