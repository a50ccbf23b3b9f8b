"""Peeled programs mean what they meant, however many iterations are copied."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.cut.test_build import meaning, memory_after
from tests.dfg.programs import Assign, For, Jump, Load, Store, lower, programs
from vividc.dfg.cut.build import build_kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.peel import peel
from vividc.ssa.rewrite.simplify import simplify


@settings(max_examples=100, deadline=None, derandomize=True)
@given(programs(), st.integers(0, 3), st.integers(0, 4))
def test_peeled_programs_mean_the_same(
    program: tuple[object, ...], iterations: int, which: int
) -> None:
    function = canonical_loops(simplify(lower(program)))
    loops = find_loops(function)
    if loops:
        function = peel(function, loops[which % len(loops)], iterations)
    assert check_function(function) == []
    function = simplify(function)
    assert check_function(function) == []
    assert memory_after(build_kernel(function)) == meaning(program)


def test_a_loop_of_as_many_iterations_as_are_peeled_goes() -> None:
    program = (For(0, 0, 3, (Load(1, 0), Assign(1, "add", 1, 0, None), Store(0, 1))),)
    function = canonical_loops(simplify(lower(program)))
    (loop,) = find_loops(function)
    peeled = simplify(peel(function, loop, 4))
    assert find_loops(peeled) == ()
    assert len(peeled.blocks) == 1
    assert memory_after(build_kernel(peeled)) == meaning(program)


def test_a_break_from_a_copy_hands_on_its_values() -> None:
    body = (Load(1, 0), Jump("break", 2, 1), Assign(2, "add", 1, 0, None))
    program = (For(0, 0, 5, body), Store(2, 1))
    function = canonical_loops(simplify(lower(program)))
    peeled = peel(function, find_loops(function)[0], 2)
    assert check_function(peeled) == []
    assert memory_after(build_kernel(peeled)) == meaning(program)
