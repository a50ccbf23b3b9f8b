"""Flattened nests mean what they meant, and are one loop."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.cut.test_build import meaning, memory_after
from tests.programs import Assign, For, If, Jump, Load, Store, While, lower, nests, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
from vividc.errors import InternalError
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.analysis.counters import Counter, moved_limit
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function, Input, Phi
from vividc.ssa.loops.flatten.flatten import flatten, flattened_iterations
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.simplify import simplify

Program = tuple[object, ...]


def prepared(program: Program) -> Function:
    """The program as the compiler has it before transformations."""
    return canonical_loops(simplify(lower(program)))


def flattened(function: Function) -> Function:
    """`function` with every nest flattened that can be, inside out."""
    while True:
        for loop in find_loops(function):
            found = flatten(function, loop.header)
            if found is not None:
                assert check_function(found) == []
                function = found
                break
        else:
            return function


def run(function: Function, header: str) -> Function | None:
    return flatten(function, header)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


def assert_same(program: Program, function: Function) -> None:
    kernel = build_kernel(function)
    assert memory_after(kernel) == meaning(program)
    assert memory_after(optimize_kernel(kernel)) == meaning(program)


@settings(max_examples=60)
@given(nests())
def test_flattened_nests_mean_the_same(program: Program) -> None:
    assert_same(program, flattened(prepared(program)))


@settings(max_examples=60)
@given(programs())
def test_flattened_programs_mean_the_same(program: Program) -> None:
    before = prepared(program)
    demand_same(before, flattened(before), tries=2)


@pytest.mark.slow
@settings(max_examples=2000)
@given(nests())
def test_many_flattened_nests_mean_the_same(program: Program) -> None:
    assert_same(program, flattened(prepared(program)))


@settings(max_examples=40)
@given(nests(depth=2))
def test_a_flattened_loop_may_run_block_by_block(program: Program) -> None:
    function = flattened(prepared(program))
    headers = frozenset(loop.header for loop in find_loops(function))
    kernel = build_kernel(replace(function, sequential=headers))
    assert memory_after(kernel) == meaning(program)


def test_a_rectangular_nest_is_counted() -> None:
    """No predicate ends it: the controller does."""
    program = (For(0, 0, 4, (For(1, 0, 3, (Load(2, 1), Store(0, 2))),)),)
    function = flattened(prepared(program))
    (loop,) = [r for r in build_kernel(function).regions if r.kind == "loop"]
    assert loop.counted
    assert all(node.control is None for node in loop.dfg.nodes)
    assert_same(program, function)


@pytest.mark.parametrize("inner", [-1, 0, 1, 2])
@pytest.mark.parametrize("outer", [-1, 0, 1, 3])
def test_rows_of_any_length(outer: int, inner: int) -> None:
    around = (Assign(2, "add", 2, 0, None), Store(0, 2))
    for rest in ((), around):
        body = (*rest, For(1, 0, inner, (Load(2, 1), Store(2, 0))), *rest)
        program = (For(0, 0, outer, body),)
        assert_same(program, flattened(prepared(program)))


def test_loads_on_the_way_that_a_store_may_change_run_once() -> None:
    body = (Load(2, 0), For(1, 0, 3, (Store(0, 1), Assign(0, "add", 0, 2, None))), Store(1, 2))
    program = (For(0, 0, 4, body),)
    assert_same(program, flattened(prepared(program)))


def test_an_iteration_may_skip_the_inner_loop() -> None:
    inner = For(1, 0, 3, (Store(0, 1), Jump("break", 2, 1)))
    program = (For(0, 0, 5, (If(0, 2, (inner,), (Assign(2, "sub", 2, 2, 3),)),)),)
    function = flattened(prepared(program))
    assert len(find_loops(function)) == 1
    assert_same(program, function)


def test_siblings_are_left() -> None:
    inner = For(1, 0, 3, (Store(0, 1),))
    function = prepared((For(0, 0, 5, (inner, inner)),))
    assert all(flatten(function, loop.header) is None for loop in find_loops(function))


def test_a_sequential_loop_is_left() -> None:
    function = prepared((For(0, 0, 5, (For(1, 0, 3, (Store(0, 1),)),)),))
    inner, outer = find_loops(function)
    kept = replace(function, sequential=frozenset({inner.header}))
    assert flatten(kept, outer.header) is None
    assert flatten(function, outer.header) is not None


def test_iterations_of_the_flattened_loop() -> None:
    function = prepared((For(0, 0, 5, (While(1, 2, 3, (Store(0, 1),)),)),))
    inner, outer = find_loops(function)
    trips = {outer.header: 5.0, inner.header: 4.0}
    assert flattened_iterations(function, outer.header, trips) == 20.0
    with pytest.raises(InternalError):
        flattened_iterations(function, inner.header, trips)


def wrapped(word: int) -> int:
    """As a signed word."""
    return (word + 2**31) % 2**32 - 2**31


edges = st.integers(-(2**31), 2**31 - 1) | st.sampled_from(
    [-(2**31), -(2**31) + 1, 2**31 - 1, 2**31 - 2, 0]
)


@given(edges, edges, st.integers(-5, 5).filter(bool))
def test_a_moved_limit_tells_the_last_iteration(at: int, limit: int, step: int) -> None:
    counter = Counter(Phi(0, Type.I32, ()), Input("0"), step, Input("1"))
    moved = limit
    for op, word in moved_limit(counter):
        if op is Opcode.ADD:
            moved += word
            assert moved == wrapped(moved)
        else:
            moved = max(moved, word) if op is Opcode.SMAX else min(moved, word)
    goes_on = at < moved if step > 0 else at > moved
    assert goes_on == (at + step < limit if step > 0 else at + step > limit)
