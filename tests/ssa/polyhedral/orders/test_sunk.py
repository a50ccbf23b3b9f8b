"""Inner loops compute what the source computes before them, and mean the same."""

from __future__ import annotations

import pytest

import vividc
from tests.ssa import support
from tests.ssa.polyhedral.sums import random_sums
from tests.ssa.polyhedral.test_generate import demand_same, parts_of
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import orders
from vividc.ssa.polyhedral.orders.sunk import sunk
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

SIGNATURE = "void(int32[:, ::1], int32[:, ::1], int32)"


@vividc.kernel(SIGNATURE)
def before_a_loop(a, b, n):
    for i in range(n):
        for k in range(n):
            w = b[i, k] * n
            for j in range(i):
                a[i, j] += w * b[j, k]


@vividc.kernel(SIGNATURE)
def before_two_loops(a, b, n):
    """Either would need it."""
    for i in range(n):
        for k in range(n):
            w = b[i, k] * n
            for j in range(i):
                a[i, j] += w * b[j, k]
            for j in range(k):
                a[j, i] -= w


@vividc.kernel(SIGNATURE)
def of_what_is_stored(a, b, n):
    for i in range(n):
        for k in range(n):
            w = a[i, k] * n
            for j in range(i):
                a[i, j] += w * b[j, k]


@vividc.kernel(SIGNATURE)
def dear(a, b, n):
    """A quotient is not computed again."""
    for i in range(n):
        for k in range(n):
            w = b[i, k] // n
            for j in range(i):
                a[i, j] += w * b[j, k]


@vividc.kernel(SIGNATURE)
def carried(a, b, n):
    """A sum is of all iterations."""
    for i in range(n):
        w = 0
        for k in range(n):
            w += b[i, k]
            for j in range(i):
                a[i, j] += w


@pytest.mark.parametrize(
    "kernel", [before_two_loops, of_what_is_stored, dear, carried], ids=lambda one: one.name
)
def test_what_has_to_stay_stays(kernel: vividc.KernelFunction) -> None:
    for scop in parts_of(tidy(kernel.lower())):
        assert sunk(scop) is None


def test_a_loop_may_be_interchanged_with_that_of_what_was_computed_before() -> None:
    function = tidy(before_a_loop.lower())
    [scop] = parts_of(function)
    part = sunk(scop)
    assert part is not None
    assert len(part.statements) == 1
    assert not part.statements[0].reads
    before, after = (list(orders(tree_of(one), Relations(one))) for one in (scop, part))
    assert len(after) > len(before)
    for tree in after:
        loops = loops_of(tree, Relations(part))
        made = loops if isinstance(loops, Refusal) else generate(part, loops)
        assert not isinstance(made, Refusal), made.reason
        support.demand_same(function, tidy(made.function))


def test_random_sums() -> None:
    for seed in range(60):
        function = tidy(random_sums(seed))
        for scop in parts_of(function):
            part = sunk(scop)
            if part is None:
                continue
            loops = loops_of(tree_of(part), Relations(part))
            made = loops if isinstance(loops, Refusal) else generate(part, loops)
            assert not isinstance(made, Refusal), made.reason
            demand_same(function, tidy(made.function), f"seed {seed}")
