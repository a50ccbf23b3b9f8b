"""Unrolled programs mean what they meant, for all factors and trip counts."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import Assign, For, Load, Store, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.unroll import unroll
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

BODY = (Load(1, 0), Assign(1, "add", 1, 0, None), Store(0, 1))


def run(function: Function, header: str, factor: str) -> object:
    done = unroll(function, loop_at(function, header), int(factor))
    if isinstance(done, Refusal):
        return done.reason
    return done.function, f"main {done.main}, rest {done.rest}"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


@settings(max_examples=100)
@given(programs(), st.sampled_from([2, 4, 8]), st.integers(0, 4))
def test_unrolled_programs_mean_the_same(
    program: tuple[object, ...], factor: int, which: int
) -> None:
    before = tidy(lower(program))
    loops = find_loops(before)
    done = unroll(before, loops[which % len(loops)], factor) if loops else None
    if done is None or isinstance(done, Refusal):
        return
    for after in (done.function, tidy(done.function)):
        assert check_function(after) == []
        demand_same(before, after, tries=2)


@pytest.mark.parametrize("factor", [2, 4])
@pytest.mark.parametrize("count", range(10))
def test_iterations_left_over_run(count: int, factor: int) -> None:
    before = tidy(lower((For(0, 0, count, BODY), Store(0, 0))))
    done = unroll(before, find_loops(before)[0], factor)
    assert not isinstance(done, Refusal)
    demand_same(before, tidy(done.function), tries=2)


def test_both_loops_are_counted() -> None:
    """The controller ends them, no predicate."""
    function = tidy(lower((For(0, 0, 9, BODY),)))
    done = unroll(function, find_loops(function)[0], 4)
    assert not isinstance(done, Refusal)
    kernel = build_kernel(tidy(done.function))
    loops = [region for region in kernel.regions if region.kind == "loop"]
    assert [loop.counted for loop in loops] == [True, True]
    assert {loop.header for loop in loops} == {done.main, done.rest}
