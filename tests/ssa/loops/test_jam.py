"""Jammed nests mean what they meant; where the order of accesses matters they are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import Access, Nest, affine_nests, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.jam import Jammed, jam
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

ROWS = Nest(6, 3, (), (Access("load", 1, 4),), (Access("store", 1, 0, 40),))


def outer_loop(function: Function) -> Loop:
    return max(find_loops(function), key=lambda loop: len(loop.blocks))


def jammed(nest: Nest, factor: int) -> Jammed | Refusal:
    function = tidy(lower(nest.program))
    return jam(function, outer_loop(function), factor)


def run(function: Function, header: str, factor: str) -> object:
    done = jam(function, loop_at(function, header), int(factor))
    if isinstance(done, Refusal):
        return done.reason
    old = f"rest {done.rest} {done.rest_inner}"
    return done.function, f"main {done.main}, inner {done.inner}, {old}"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


def demand_jams_mean_the_same(before: Function, loop: Loop, factor: int) -> None:
    done = jam(before, loop, factor)
    if not isinstance(done, Refusal):
        for after in (done.function, tidy(done.function)):
            assert check_function(after) == []
            demand_same(before, after, tries=2)


@settings(max_examples=200)
@given(affine_nests(), st.sampled_from([2, 4]))
def test_jammed_nests_mean_the_same(nest: Nest, factor: int) -> None:
    before = tidy(lower(nest.program))
    if len(find_loops(before)) > 1:
        demand_jams_mean_the_same(before, outer_loop(before), factor)


@settings(max_examples=60)
@given(programs(), st.sampled_from([2, 4]))
def test_random_programs_mean_the_same(program: tuple[object, ...], factor: int) -> None:
    before = tidy(lower(program))
    for loop in find_loops(before):
        demand_jams_mean_the_same(before, loop, factor)


@pytest.mark.parametrize("rows", range(10))
def test_rows_left_over_run(rows: int) -> None:
    before = tidy(lower(replace(ROWS, outer=rows).program))
    done = jam(before, outer_loop(before), 4)
    assert isinstance(done, Jammed)
    demand_same(before, tidy(done.function), tries=2)


def test_the_copies_share_one_inner_loop() -> None:
    done = jammed(ROWS, 2)
    assert isinstance(done, Jammed)
    kernel = build_kernel(tidy(done.function))
    loads = {
        region.header: sum(node.op.value == "load" for node in region.dfg.nodes)
        for region in kernel.regions
        if region.kind == "loop"
    }
    assert loads == {done.inner: 2, done.rest_inner: 1}
