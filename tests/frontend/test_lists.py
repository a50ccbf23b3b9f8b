"""Lists of fixed length: tuples, where they are only read or made arrays of, or arrays."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numba
import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import VividcWarning


def numbers(x, n):
    made = np.array([n, n + 1, 4])
    for i in range(len(x)):
        x[i] += made[i % 3]


def mixed(x, n):
    made = np.array([x[0], np.float32(n)], dtype=np.float32)
    return made, np.array([n, 2.5]), np.array([True, False]), np.asarray([1, 2])


def rows(x, n):
    made = np.array([[1, 2, 3], [4, n, 6]])
    return made, made[n - 3, 1]


def named(x, n):
    items = [n, n * 2]
    again = items
    return np.array(items), np.array(again)[1]


def weights(x, n):
    taps = [0.5, -1.0, 0.25]
    for i in range(len(x) - 2):
        total = np.float32(0)
        for j in range(len(taps)):
            total += np.float32(taps[j]) * x[i + j]
        x[i] = total


def steps(x, n):
    for i, step in enumerate([1, 2, 4]):
        x[i] = step + n
    for step in [3, 5]:
        x[step] += step


@numba.njit
def helper(a, b):
    return np.array([a, b]).sum()


def called(x, n):
    x[0] = helper(n, x[1])


@numba.njit
def tangent(v):
    made = [0.0, 0.0, 1.0]
    if abs(v[0]) > abs(v[1]):
        made[0] = -v[1]
        made[-1] = v[0]
    else:
        made[1] = v[2] * 2
    return np.asarray(made)


def assigned(x, n):
    counts = [0, 0, 0]
    again = counts
    for i in range(len(x)):
        again[i % len(counts)] += i
    counts[n - 1] = 7
    before = np.array(counts)
    counts[0] += 1
    x[:3] = tangent(x[:3])
    x[3:] = tangent(x[3:])
    return before, np.array(counts)


@pytest.mark.parametrize(
    "function", [numbers, mixed, rows, named, weights, steps, called, assigned]
)
def test_lists_of_fixed_length(function: Callable[..., object]) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        program = words_in_blocks(kernel.lower())
    x = np.arange(6, dtype=np.float32)
    mine, theirs = x.copy(), x.copy()
    expected, found = kernel(theirs, np.int32(3)), vividc.simulate(program, mine, 3).value
    assert np.array_equal(mine, theirs)
    if expected is not None:
        for one, other in zip(found, expected, strict=True):
            assert np.asarray(one).dtype == np.asarray(other).dtype
            assert np.array_equal(one, other)


def cut(x, n):
    items = [1, 2, 3]
    items[n] = 4
    x[0] = items[1:][0]


def not_copied(x, n):
    items = [1, 2, 3]
    made = np.asarray(items)
    items[n] = 4
    x[0] = made[1]


def grown(x, n):
    items = [1, 2, 3]
    items.append(n)
    x[0] = len(items)


def two_types(x, n):
    items = [1, 2.5]
    x[0] = items[0] // 2


def passed_on(x, n):
    items = [1, 2]
    x[0] = np.array(items)[0] + sum(items)


@pytest.mark.parametrize("function", [cut, not_copied, grown, two_types, passed_on])
def test_lists_that_are_more_than_read_stay_lists(function: Callable[..., object]) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        program = words_in_blocks(kernel.lower())
    mine, theirs = np.zeros(2, np.float32), np.zeros(2, np.float32)
    kernel(theirs, np.int32(1))
    vividc.simulate(program, mine, 1)
    assert np.array_equal(mine, theirs)


def test_numbas_own_lists_stay_lists() -> None:
    @numba.njit
    def host(n):
        items = [1, 2, 3]
        again = [items[0]]
        for i in items:
            again.append(i)
        return np.array(items).sum() + len(again) + n

    assert host(2) == 12
