"""Loops with partial results mean what they meant, for all factors and trip counts."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import Assign, For, Load, Store, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.grouped import Grouped, unroll_masked, with_partial_results
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

BODY = (Load(1, 0), Assign(2, "add", 2, 1, None))


def run(function: Function, header: str, factor: str, masked: str = "") -> object:
    way = unroll_masked if masked else with_partial_results
    done = way(function, loop_at(function, header), int(factor))
    return done.reason if isinstance(done, Refusal) else done.function


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


WAYS = st.sampled_from([with_partial_results, unroll_masked])


@settings(max_examples=150)
@given(programs(), WAYS, st.sampled_from([2, 4, 8]), st.integers(0, 4))
def test_random_programs_mean_the_same(
    program: tuple[object, ...],
    way: Callable[[Function, Loop, int], Grouped | Refusal],
    factor: int,
    which: int,
) -> None:
    before = tidy(lower(program))
    loops = find_loops(before)
    done = way(before, loops[which % len(loops)], factor) if loops else None
    if done is None or isinstance(done, Refusal):
        return
    for after in (done.function, tidy(done.function)):
        assert check_function(after) == []
        demand_same(before, after, tries=2)


@pytest.mark.parametrize("way", [with_partial_results, unroll_masked])
@pytest.mark.parametrize("factor", [2, 4])
@pytest.mark.parametrize("count", range(10))
def test_what_fills_no_group_is_masked(
    count: int, factor: int, way: Callable[[Function, Loop, int], Grouped | Refusal]
) -> None:
    before = tidy(lower((For(0, 0, count, BODY), Store(0, 2))))
    done = way(before, find_loops(before)[0], factor)
    assert not isinstance(done, Refusal)
    demand_same(before, tidy(done.function), tries=2)
    loops = [r for r in build_kernel(tidy(done.function)).regions if r.kind == "loop"]
    assert [loop.counted for loop in loops] == [True]
