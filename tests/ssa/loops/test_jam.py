"""Jammed nests mean what they meant; where the order of accesses matters they are refused."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.cut.test_build import meaning, memory_after
from tests.dfg.programs import lower, programs
from tests.ssa.loops.nests import NestProgram, Step, lower_nest, nest_memory, nest_programs
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.jam import Jammed, jam
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

ROWS = NestProgram(6, 3, (), (Step("load", 1, 4),), (Step("store", 1, 0, 40),), fresh=True)


def outer_loop(function: Function) -> Loop:
    return max(find_loops(function), key=lambda loop: len(loop.blocks))


def jammed(program: NestProgram, factor: int) -> Jammed | Refusal:
    function = tidy(lower_nest(program))
    return jam(function, outer_loop(function), factor)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(nest_programs(), st.sampled_from([2, 4]))
def test_jammed_nests_mean_the_same(program: NestProgram, factor: int) -> None:
    function = tidy(lower_nest(program))
    if len(find_loops(function)) < 2:
        return
    done = jam(function, outer_loop(function), factor)
    if isinstance(done, Refusal):
        return
    assert check_function(done.function) == []
    after = tidy(done.function)
    assert check_function(after) == []
    assert nest_memory(after) == nest_memory(lower_nest(program))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(programs(), st.sampled_from([2, 4]))
def test_random_programs_mean_the_same(program: tuple[object, ...], factor: int) -> None:
    function = tidy(lower(program))
    for loop in find_loops(function):
        done = jam(function, loop, factor)
        if not isinstance(done, Refusal):
            assert check_function(done.function) == []
            assert memory_after(build_kernel(tidy(done.function))) == meaning(program)


@pytest.mark.parametrize("rows", range(10))
def test_rows_left_over_run(rows: int) -> None:
    program = replace(ROWS, outer=rows)
    done = jammed(program, 4)
    assert isinstance(done, Jammed)
    assert nest_memory(tidy(done.function)) == nest_memory(lower_nest(program))


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


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        (replace(ROWS, fresh=False), "needs the one before to be complete"),
        (replace(ROWS, after=(Step("store", 1, 0, 3),)), "may depend"),
        (replace(ROWS, body=(Step("store", 2, 1, 0),)), "may depend"),
    ],
)
def test_dependent_iterations_are_refused(program: NestProgram, reason: str) -> None:
    refused = jammed(program, 4)
    assert isinstance(refused, Refusal)
    assert reason in refused.reason


def test_dependences_that_keep_their_order_are_not() -> None:
    """Iteration i + 1 reads at j what iteration i wrote at j, and both stay in order."""
    body = (Step("load", 0, 1, 3), Step("store", 0, 1, 3))
    done = jammed(NestProgram(6, 5, (), body, (), fresh=True), 4)
    assert isinstance(done, Jammed)
