"""Jammed nests mean what they meant; where the order of accesses matters they are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import Access, Nest, affine_nests, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.compiler.planning.nests.parts import jammed
from vividc.compiler.planning.state import State
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.check import check_function
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

ROWS = Nest(6, 3, (), (Access("load", 1, 4),), (Access("store", 1, 0, 40),))


def outer_loop(function: Function) -> Loop:
    return max(find_loops(function), key=lambda loop: len(loop.blocks))


def jam(function: Function, header: str, factor: int) -> State | Refusal:
    trips = expected_trips(function, {})
    return jammed(State(function, trips), header, factor, trips)


def run(function: Function, header: str, factor: str) -> str:
    loop_at(function, header)
    done = jam(function, header, int(factor))
    if isinstance(done, Refusal):
        return done.reason
    assert check_function(done.function) == []
    return "may be jammed"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


def demand_jams_mean_the_same(before: Function, header: str, factor: int) -> None:
    done = jam(before, header, factor)
    if not isinstance(done, Refusal):
        assert check_function(done.function) == []
        demand_same(before, done.function, tries=2)


@settings(max_examples=100)
@given(affine_nests(), st.sampled_from([2, 3, 4]))
def test_jammed_nests_mean_the_same(nest: Nest, factor: int) -> None:
    before = tidy(lower(nest.program))
    if len(find_loops(before)) > 1:
        demand_jams_mean_the_same(before, outer_loop(before).header, factor)


@settings(max_examples=60)
@given(programs(), st.sampled_from([2, 4]))
def test_random_programs_mean_the_same(program: tuple[object, ...], factor: int) -> None:
    before = tidy(lower(program))
    for loop in find_loops(before):
        demand_jams_mean_the_same(before, loop.header, factor)


@pytest.mark.parametrize("rows", range(10))
def test_rows_left_over_run(rows: int) -> None:
    before = tidy(lower(replace(ROWS, outer=rows).program))
    done = jam(before, outer_loop(before).header, 4)
    assert isinstance(done, State)
    demand_same(before, done.function, tries=2)


def test_the_copies_share_one_inner_loop() -> None:
    before = tidy(lower(ROWS.program))
    done = jam(before, outer_loop(before).header, 2)
    assert isinstance(done, State)
    loads = [
        sum(node.op.value == "load" for node in region.dfg.nodes)
        for region in build_kernel(done.function).regions
        if region.kind == "loop"
    ]
    assert loads == [2]  # an even number of rows leaves none behind
