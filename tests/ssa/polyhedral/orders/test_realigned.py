"""Parts written in other orders mean the same: another loop outermost, statements merged."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.sums import random_sums
from tests.ssa.polyhedral.test_generate import parts_of
from tests.ssa.polyhedral.test_orders import (
    generated,
    jammed_trees,
    rooted,
    symmetric,
)
from vividc.ssa.interpret import interpret
from vividc.ssa.polyhedral.orders.bands import Bands
from vividc.ssa.polyhedral.orders.families import families_of
from vividc.ssa.polyhedral.orders.realigned import other_orders, realigned
from vividc.ssa.polyhedral.orders.search import describe, is_legal
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.tidy import tidy

SIGNATURE = "void(int32[:, ::1], int32[:, ::1])"


@vividc.kernel(SIGNATURE)
def factored(a, b):
    """Two triangles of one matrix (lu)."""
    for i in range(a.shape[0]):
        for j in range(i):
            for k in range(j):
                a[i, j] -= a[i, k] * a[k, j]
            a[i, j] += 3 * a[j, j]
        for j in range(i, a.shape[0]):
            for k in range(i):
                a[i, j] -= a[i, k] * a[k, j]


@vividc.kernel(SIGNATURE)
def waiting(a, b):
    """The same with sums in scalars (ludcmp)."""
    for i in range(a.shape[0]):
        for j in range(i):
            w = a[i, j]
            for k in range(j):
                w -= a[i, k] * a[k, j]
            a[i, j] = w + 3 * a[j, j]
        for j in range(i, a.shape[0]):
            w = a[i, j]
            for k in range(i):
                w -= a[i, k] * a[k, j]
            a[i, j] = w


@vividc.kernel(SIGNATURE)
def twice(a, b):
    """Two loops over the same elements: no iteration is one of both."""
    for i in range(a.shape[0]):
        for j in range(i):
            a[i, j] -= a[j, i] * b[i, j]
        for j in range(i):
            a[i, j] -= a[j, i] * b[i, j]


@vividc.kernel(SIGNATURE)
def ahead(a, b):
    """Columns of b, each from the column of a before it: later by one, they are in one loop."""
    for i in range(a.shape[0]):
        for j in range(a.shape[0]):
            a[i, j] += a[j, i] * 3
        for j in range(1, a.shape[0]):
            b[i, j] -= a[i, j - 1]


@vividc.kernel("void(int32[:, :, ::1])")
def across(a):
    """The second nest does to the element i + j what the first one does to its own."""
    for r in range(a.shape[0]):
        for i in range(a.shape[2]):
            for j in range(a.shape[2]):
                a[r, i, j] *= 3
        for i in range(a.shape[2]):
            for j in range(a.shape[2]):
                a[r, i + j, j] *= 3


ORDERS = [
    (factored, "i8[i9[S4], i10[i11[S3]]] of 2"),
    (waiting, "i8[i9[S5], i10[i11[S4]]] of 2"),
    (rooted, "i8[S7, i9[S4], i10[i11[S3]]] of 3"),
]


@pytest.mark.parametrize(("kernel", "order"), ORDERS, ids=lambda item: getattr(item, "name", ""))
def test_the_outermost_loop_carries_the_most(kernel: vividc.KernelFunction, order: str) -> None:
    """k in factorisations, where what the source has in two places is one statement."""
    [scop] = parts_of(tidy(kernel.lower()))
    assert [describe(tree_of(one)) for one in realigned(Relations(scop), 1)] == [order]


def test_only_what_a_coordinate_alone_counts_is_one_statement() -> None:
    [scop] = parts_of(tidy(across.lower()))
    assert [len(family) for family in families_of(Relations(scop))] == [1, 1]


def test_nothing_is_written_in_two_orders_at_once() -> None:
    """A sum in a register cannot wait for other rows."""
    [scop] = parts_of(tidy(symmetric.lower()))
    assert list(other_orders(Relations(scop))) == []


def test_only_loops_of_sums_are_moved_outwards() -> None:
    """Columns outermost are what an interchange finds."""
    [scop] = parts_of(tidy(twice.lower()))
    assert list(other_orders(Relations(scop)))
    assert realigned(Relations(scop), 9) == []


KERNELS = (factored, waiting, rooted, twice, ahead)


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.name)
def test_realigned_parts_mean_the_same(kernel: vividc.KernelFunction) -> None:
    function = tidy(kernel.lower())
    [scop] = parts_of(function)
    parts = list(itertools.islice(other_orders(Relations(scop)), 2))
    assert parts
    for part in parts:
        relations = Relations(part)
        for tree in (tree_of(part), *itertools.islice(jammed_trees(part, relations, 2, 2), 2)):
            after = generated(part, relations, tree)
            for n in (0, 1, 2, 5):
                numbers = np.random.default_rng(n)
                values = [numbers.integers(-9, 9, (n, n), dtype=np.int32) for _ in range(2)]
                old, new = ([value.copy() for value in values] for _ in range(2))
                interpret(function, *old)
                interpret(after, *new)
                same = all(np.array_equal(x, y) for x, y in zip(old, new, strict=True))
                assert same, f"{describe(tree)}, n = {n}"


def test_random_orders_are_legal_before_that_is_asked() -> None:
    """What bands find keeps all dependences by itself, and families share no iteration."""
    merged = found = 0
    for seed in range(40):
        for scop in parts_of(tidy(random_sums(seed))):
            relations = Relations(scop)
            families = tuple(families_of(relations))
            merged += any(len(family) > 1 for family in families)
            for band in itertools.islice(Bands(relations, families).found(), 6):
                found += 1
                assert is_legal(band.tree(families), relations), f"seed {seed}: {band}"
    assert merged
    assert found > 30
