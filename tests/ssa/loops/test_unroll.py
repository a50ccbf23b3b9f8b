"""Unrolled programs mean what they meant, for all factors and trip counts."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.cut.test_build import meaning, memory_after
from tests.dfg.programs import Assign, For, Jump, Load, Store, lower, programs
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.loops.unroll import unroll
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

BODY = (Load(1, 0), Assign(1, "add", 1, 0, None), Store(0, 1))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(programs(), st.sampled_from([2, 4, 8]), st.integers(0, 4))
def test_unrolled_programs_mean_the_same(
    program: tuple[object, ...], factor: int, which: int
) -> None:
    function = tidy(lower(program))
    assert check_function(function) == []
    loops = find_loops(function)
    if loops:
        done = unroll(function, loops[which % len(loops)], factor)
        if isinstance(done, Refusal):
            return
        assert check_function(done.function) == []
        function = tidy(done.function)
    assert check_function(function) == []
    assert memory_after(build_kernel(function)) == meaning(program)


@pytest.mark.parametrize("factor", [2, 4])
@pytest.mark.parametrize("count", range(10))
def test_iterations_left_over_run(count: int, factor: int) -> None:
    program = (For(0, 0, count, BODY), Store(0, 0))
    function = tidy(lower(program))
    done = unroll(function, find_loops(function)[0], factor)
    assert not isinstance(done, Refusal)
    kernel = build_kernel(tidy(done.function))
    assert memory_after(kernel) == meaning(program)


def test_both_loops_are_counted() -> None:
    function = tidy(lower((For(0, 0, 9, BODY),)))
    done = unroll(function, find_loops(function)[0], 4)
    assert not isinstance(done, Refusal)
    kernel = build_kernel(tidy(done.function))
    loops = [region for region in kernel.regions if region.kind == "loop"]
    assert [loop.counted for loop in loops] == [True, True]
    assert {loop.header for loop in loops} == {done.main, done.rest}


def test_copies_keep_their_breaks() -> None:
    program = (For(0, 0, 9, (Load(1, 0), Jump("break", 2, 1), Store(0, 2))), Store(1, 0))
    function = tidy(lower(program))
    done = unroll(function, find_loops(function)[0], 4)
    assert not isinstance(done, Refusal)
    assert memory_after(build_kernel(tidy(done.function))) == meaning(program)


@pytest.mark.parametrize("factor", [0, 1, 3])
def test_other_factors_are_refused(factor: int) -> None:
    function = tidy(lower((For(0, 0, 9, BODY),)))
    refused = unroll(function, find_loops(function)[0], factor)
    assert refused == Refusal("the factor is no power of two")
