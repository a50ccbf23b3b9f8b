"""Limits of 64 bits as words: `range(n - 1)` is a counted loop, and right for the least and the
greatest n.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from vividc.machine.opcodes import Opcode
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function, Instr, definition_of


def one_less(x, n):
    for i in range(n - 1):
        if i >= len(x):
            break
        x[i] += 1


def from_one(x, n):
    for i in range(1, n - 2):
        if i >= len(x):
            return i
        x[i] += i
    return n


def in_both(x, n):
    for i in range(1, n - 1):
        if i > 3:
            break
        for j in range(2, n - 1, 2):
            if j >= len(x):
                break
            x[j] += i
            x[0] += 1


def downwards(x, n):
    for i in range(n - 1, 2, -1):
        if i < n - 6:
            break
        x[i & 3] += 1


def from_below(x, n):
    for i in range(-3, n - 5):
        if i > 4:
            break
        x[i + 3] += 1


def a_while(x, n):
    i = 0
    while i < n - 1:
        x[i & 7] += 1
        i += 1
        if i > 9:
            break


def halved(x, n):
    for i in range((n - 3) // 2):
        if i >= len(x):
            break
        x[i] += 1


KERNELS = (one_less, from_one, in_both, downwards, from_below, a_while, halved)
INTEGERS = (
    -(1 << 31),
    -(1 << 31) + 1,
    -7,
    -1,
    0,
    1,
    2,
    3,
    4,
    5,
    7,
    12,
    (1 << 31) - 2,
    (1 << 31) - 1,
)


def kernel_of(function: Callable[..., object]) -> vividc.frontend.KernelFunction:
    return vividc.kernel("(int32[::1], int32)")(function)


@pytest.mark.parametrize("function", KERNELS)
def test_loops_run_as_often_as_numbas(function: Callable[..., object]) -> None:
    kernel = kernel_of(function)
    lowered = kernel.lower()
    for n in INTEGERS:
        theirs, mine = np.zeros(8, np.int32), np.zeros(8, np.int32)
        expected = kernel(theirs, np.int32(n))
        assert interpret(lowered, mine, np.int32(n)) == expected
        assert np.array_equal(mine, theirs)


def simple(x, y, n):
    for i in range(1, n - 1):
        for j in range(1, n - 1):
            y[i, j] = x[i - 1, j] + x[i, j + 1]


def headers_tests(lowered: Function) -> list[object]:
    """What the headers of loops test."""
    headers = (lowered.by_name[loop.header] for loop in find_loops(lowered))
    made = (definition_of(lowered, header.branch.cond) for header in headers)
    return [op.op for op in made if isinstance(op, Instr)]


def test_a_limit_of_64_bits_is_a_word_in_all_loops_of_a_nest() -> None:
    lowered = vividc.kernel("void(float32[:, ::1], float32[:, ::1], int32)")(simple).lower()
    assert headers_tests(lowered) == [Opcode.ICMP_SLT, Opcode.ICMP_SLT]
    extremes = [op for block in lowered.blocks for op in block.instrs if op.op is Opcode.SMAX]
    assert len(extremes) == 1


def test_a_limit_that_may_be_too_great_is_left() -> None:
    def beyond(x, n):
        for i in range(n + 1):
            x[i & 7] += 1

    assert headers_tests(kernel_of(beyond).lower()) != [Opcode.ICMP_SLT]
