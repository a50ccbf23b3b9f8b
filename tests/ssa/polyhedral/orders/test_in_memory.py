"""Sums wait in the elements that they end in, where nothing else looks at these meanwhile."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.sums import random_sums
from tests.ssa.polyhedral.test_generate import demand_same, parts_of
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.in_memory import in_memory
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

SIGNATURE = "void(int32[:, ::1], int32[:, ::1], int32)"


@vividc.kernel(SIGNATURE)
def begun_there(a, b, n):
    for i in range(n):
        for j in range(i):
            w = a[i, j]
            for k in range(j):
                w -= a[i, k] * b[k, j]
            a[i, j] = w * a[j, j]


@vividc.kernel(SIGNATURE)
def begun_elsewhere(a, b, n):
    for i in range(n):
        for j in range(i):
            w = b[i, j]
            for k in range(j):
                w -= a[i, k] * b[k, j]
            a[i, j] = w


@vividc.kernel(SIGNATURE)
def read_meanwhile(a, b, n):
    """k comes past j: the element is read as it was."""
    for i in range(n):
        for j in range(i):
            w = a[i, j]
            for k in range(i):
                w -= a[i, k] * b[k, j]
            a[i, j] = w


@vividc.kernel(SIGNATURE)
def written_meanwhile(a, b, n):
    for i in range(n):
        for j in range(i):
            w = a[i, j]
            for k in range(j + 1):
                w -= b[i, k]
                a[i, k] = w
            a[i, j] = w


@vividc.kernel(SIGNATURE)
def never_stored(a, b, n):
    for i in range(n):
        w = a[i, 0]
        for k in range(i):
            w -= b[i, k]
            a[i, k] = w


@vividc.kernel(SIGNATURE)
def read_later(a, b, n):
    """The scalar is read again behind the store."""
    for i in range(n):
        w = a[i, 0]
        for k in range(1, i):
            w -= b[i, k]
        a[i, 0] = w + 1
        for k in range(1, i):
            b[i, k] = w


@vividc.kernel("void(int8[:, ::1], int32[:, ::1], int32)")
def too_small(a, b, n):
    """A byte does not hold the sum."""
    for i in range(n):
        w = np.int32(a[i, 0])
        for k in range(1, i):
            w -= b[i, k]
        a[i, 0] = w // 256


def scalars(scop: Scop) -> int:
    """How many reads of scalars statements have."""
    return sum(len(statement.reads) for statement in scop.statements)


@pytest.mark.parametrize(
    ("kernel", "moves"),
    [
        (begun_there, True),
        (begun_elsewhere, True),
        (read_meanwhile, False),
        (written_meanwhile, False),
        (too_small, False),
        (never_stored, False),
        (read_later, False),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_sums_wait_in_memory(kernel: vividc.KernelFunction, moves: bool) -> None:
    [scop] = parts_of(tidy(kernel.lower()))
    assert scalars(scop)
    assert bool(scalars(in_memory(scop))) is not moves


def demand_same_in_memory(seed: int) -> int:
    """How many parts of a random nest have a sum in memory."""
    function = tidy(random_sums(seed))
    count = 0
    for scop in parts_of(function):
        part = in_memory(scop)
        if part is scop:
            continue
        count += 1
        loops = loops_of(tree_of(part), Relations(part))
        made = loops if isinstance(loops, Refusal) else generate(part, loops)
        assert not isinstance(made, Refusal), made.reason
        demand_same(function, tidy(made.function), f"seed {seed}")
    return count


def test_random_sums() -> None:
    assert sum(map(demand_same_in_memory, range(100))) > 3


def test_a_bound_that_is_a_counter_behind_its_loop() -> None:
    demand_same_in_memory(150)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 1000))
def test_more_random_sums(seed: int) -> None:
    demand_same_in_memory(seed)
