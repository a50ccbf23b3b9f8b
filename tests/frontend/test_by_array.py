"""Variables that are one array here and another one there: numba, the SSA interpreter and the
simulator agree.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import KernelError, VividcWarning
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function

X = np.arange(1, 7, dtype=np.float32)


def power(x, n):
    matrix = np.ones((6, 6), np.float32)
    matrix[2, 3] = 0.5
    for _ in range(n):
        x = matrix @ x
    return x


def relaxed(x, n):
    other = np.zeros_like(x)
    for _ in range(n):
        for i in range(1, len(x) - 1):
            other[i] = x[i - 1] + x[i + 1]
        x, other = other, x
    return other


def relaxed_and_copied(x, n):
    a = x.copy()
    b = x.copy()
    for _ in range(n):
        for i in range(1, len(x) - 1):
            b[i] = a[i - 1] + a[i + 1]
        a, b = b, a
    x[:] = a


def last_of_a_loop(x, n):
    row = np.zeros(2, np.float32)
    for i in range(n):
        row = np.zeros(2, np.float32)
        row[0] = x[i]
    return row


def best(x, n):
    top = x.copy()
    for i in range(n):
        made = top * np.float32(0.5) + x[i]
        if made.sum() > top.sum():
            top = made
    return top


def kicked(x, n):
    force = x + np.float32(1)
    for _ in range(n):
        x += force
        force = x * np.float32(0.25)
    return force, x[1:]


def three_in_turn(x, n):
    a = x.copy()
    b = x + np.float32(1)
    for _ in range(n):
        a, b = b, a + b
    return a


def chosen(x, n):
    a = np.ones(4, np.float32)
    b = np.zeros(4, np.float32)
    c = a if n > 2 else b
    for i in range(4):
        c[i] += x[i]
    x[0] = a[0] + np.float32(2) * b[0]
    return c


def first_or_made(x, n):
    found = x
    for i in range(n):
        if x[i] > 2:
            found = np.full(len(x), x[i], np.float32)
        found[i] += np.float32(1)
    return found


def kept_in_each_of_a_loop(x, n):
    total = np.float32(0)
    for i in range(n):
        a = np.zeros(3, np.float32)
        for j in range(i):
            b = a + x[j]
            a = b
        total += a[0]
    x[0] = total
    return x


def of_sizes(x, n):
    a = x[:1].copy()
    for i in range(n):
        a = x[:i] * np.float32(2)
    return a


def fewer_each_time(x, n):
    left, found = x.copy(), np.zeros(len(x), np.int32)
    index = np.arange(len(x))
    for i in range(n):
        left = left * np.float32(1.5)
        goes_on = left < np.float32(8)
        for j in range(len(left)):
            if not goes_on[j]:
                found[index[j]] = i
        left, index = left[goes_on], index[goes_on]
    return found, left


KERNELS = (
    *(power, relaxed, relaxed_and_copied, last_of_a_loop, best, kicked, three_in_turn, chosen),
    *(first_or_made, kept_in_each_of_a_loop, of_sizes, fewer_each_time),
)


def lowered(function: Callable[..., object]) -> Function:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        return kernel.lower()


@pytest.mark.parametrize("function", KERNELS)
def test_all_witnesses_agree(function: Callable[..., object]) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    made = lowered(function)
    program = words_in_blocks(made)
    for n in (0, 1, 2, 5):
        numbas, by_ssa, by_words = X.copy(), X.copy(), X.copy()
        expected = kernel(numbas, np.int32(n))
        value = interpret(made, by_ssa, np.int32(n))
        result = vividc.simulate(program, by_words, n)
        for found, memory in ((value, by_ssa), (result.value, by_words)):
            assert np.array_equal(memory, numbas)
            np.testing.assert_equal(found, expected)


def test_an_array_takes_the_place_of_one_that_nobody_reads_any_more() -> None:
    assert not lowered(kicked).locals
    assert len(lowered(kicked).blocks) < len(lowered(best).blocks)


def turned(x, n):
    a, b, c = x + 1, x + 2, x + 3
    d, e, f = x + 4, x + 5, x + 6
    for i in range(n):
        if x[i] > 0:
            a, b = b, a
        elif x[i] > 1:
            b, c, d = c, d, b
        else:
            e, f, a = a, e, f
        for j in range(len(x)):
            b[j] += c[j]
            d[j] *= e[j]
    return a


def test_too_many_ways_are_refused() -> None:
    with pytest.raises(KernelError, match="returns one of several arrays, and which one"):
        lowered(turned)
