"""Iterations that run together have rows of temporaries, wherever each writes before it reads."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.nests import random_nest
from tests.ssa.polyhedral.test_generate import NUMBERS, demand_same, parts_of
from vividc.ssa.interpret import interpret
from vividc.ssa.polyhedral.generate import Generated, generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import (
    describe,
    groups_with_rows,
    has_masks,
    is_legal,
    may_jam,
    with_factors,
)
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.rows import rows_of, with_own_rows
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.polyhedral.values import bounded
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def through_a_row(a, t, b):
    """t is each row of a in turn."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            t[j] = a[i, j] * 2.0
        for j in range(a.shape[1]):
            b[i, j] += t[j]


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def one_behind(a, t, b):
    """Each row of b takes the row of a before it."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            b[i, j] += t[j]
        for j in range(a.shape[1]):
            t[j] = a[i, j] * 2.0


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def fewer_each_time(a, t, b):
    """The last row leaves most of t as others have written it."""
    for i in range(a.shape[0]):
        for j in range(i, a.shape[1]):
            t[j] = a[i, j] * 2.0
        for j in range(i, a.shape[1]):
            b[i, j] += t[j]


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def one_too_many(a, t, b):
    """The last element that is read was there before."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1] - 1):
            t[j] = a[i, j] * 2.0
        for j in range(a.shape[1]):
            b[i, j] += t[j]


def part_of(kernel: vividc.KernelFunction) -> Scop:
    [scop] = parts_of(tidy(kernel.lower()))
    return scop


def generated(scop: Scop, relations: Relations, tree: Loop) -> Generated | Refusal:
    loops = loops_of(tree, relations)
    if isinstance(loops, Refusal):
        return loops
    return generate(scop, loops, masks=has_masks(tree), rows=rows_of(tree))


@pytest.mark.parametrize("factor", [2, 3, 4, 8])
@pytest.mark.parametrize("rows", [0, 1, 2, 5, 8])
def test_rows_of_a_temporary_give_what_the_temporary_gave(factor: int, rows: int) -> None:
    scop = part_of(through_a_row)
    relations = Relations(scop)
    assert not may_jam(tree_of(scop), ((),), relations)
    [(tree, _)] = groups_with_rows(tree_of(scop), relations)
    jammed = with_factors(tree, {(): factor}, masked=True)
    assert is_legal(jammed, relations)
    made = generated(scop, relations, jammed)
    assert isinstance(made, Generated)
    assert len(made.function.locals) == factor - 1
    kept = []
    for function in (scop.function, tidy(made.function)):
        chance = np.random.default_rng(1)
        arrays = [chance.random(s, dtype=np.float32) for s in ((rows, 6), 7, (rows, 6))]
        interpret(function, *arrays)
        kept.append(arrays)
    assert all(np.array_equal(x, y) for x, y in zip(*kept, strict=True))


@pytest.mark.parametrize("kernel", [one_behind, fewer_each_time, one_too_many])
def test_what_is_no_temporary_has_no_rows(kernel: vividc.KernelFunction) -> None:
    scop = part_of(kernel)
    assert with_own_rows(tree_of(scop), Relations(scop)) is None


def test_there_are_no_rows_where_isl_would_take_too_long() -> None:
    """Seed 889 of `tests/fuzz/trees.py` had it find what a temporary's reads see without an end."""
    scop = part_of(through_a_row)
    relations, tree = Relations(scop), tree_of(scop)
    with bounded(10):
        assert with_own_rows(tree, relations) is None
    relations.endless.update("ab")
    assert with_own_rows(tree, relations) is None
    relations.endless.clear()
    assert with_own_rows(tree, relations) is not None


def test_an_array_of_unknown_size_has_no_rows() -> None:
    scop = part_of(through_a_row)
    flat = [replace(p, flat=p.name == "t") for p in scop.function.params]
    scop = replace(scop, function=replace(scop.function, params=tuple(flat)))
    assert with_own_rows(tree_of(scop), Relations(scop)) is None
    flat = [replace(p, flat=p.name != "t") for p in flat]
    scop = replace(scop, function=replace(scop.function, params=tuple(flat)))
    assert with_own_rows(tree_of(scop), Relations(scop)) is not None


def test_groups_that_are_not_full_have_no_rows_unless_masked() -> None:
    scop = part_of(through_a_row)
    relations = Relations(scop)
    [(tree, _)] = groups_with_rows(tree_of(scop), relations)
    made = generated(scop, relations, with_factors(tree, {(): 4}))
    assert isinstance(made, Refusal)
    assert "which row" in made.reason


def demand_rows_mean_the_same(seed: int) -> int:
    """How many trees with rows were generated of a random nest."""
    function = tidy(random_nest(seed, temporaries=True))
    chance = random.Random(seed)
    count = 0
    for scop in parts_of(function):
        relations = Relations(scop)
        for tree, jammed in groups_with_rows(tree_of(scop), relations):
            factors = {path: chance.choice([2, 3, 4]) for path in jammed[0]}
            for given in (factors, {path: factors[path] for path in jammed[0][:1]}):
                made = with_factors(tree, given, masked=True)
                if not is_legal(made, relations):
                    continue
                code = generated(scop, relations, made)
                if isinstance(code, Generated):
                    count += 1
                    demand_same(
                        function, tidy(code.function), f"seed {seed}: {describe(made)}", NUMBERS
                    )
    return count


_MANY, _FEW = 40, 4


@pytest.mark.parametrize("first", range(0, _MANY, _FEW))
def test_random_temporaries(first: int) -> None:
    for seed in range(first, first + _FEW):
        demand_rows_mean_the_same(seed)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(_MANY, 400, _FEW))
def test_more_random_temporaries(first: int) -> None:
    for seed in range(first, first + _FEW):
        demand_rows_mean_the_same(seed)
