"""Peeled programs mean what they meant, however many iterations are copied."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.programs import Assign, For, Load, Store, lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.peel import peel
from vividc.ssa.rewrite.simplify import simplify


def run(function: Function, header: str, iterations: str) -> Function:
    return peel(function, loop_at(function, header), int(iterations)).function


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


@settings(max_examples=60)
@given(programs(), st.integers(0, 3), st.integers(0, 4))
def test_peeled_programs_mean_the_same(
    program: tuple[object, ...], iterations: int, which: int
) -> None:
    before = canonical_loops(simplify(lower(program)))
    loops = find_loops(before)
    after = peel(before, loops[which % len(loops)], iterations).function if loops else before
    for made in (after, simplify(after)):
        assert check_function(made) == []
        demand_same(before, made, tries=2)


def test_a_loop_of_as_many_iterations_as_are_peeled_goes() -> None:
    program = (For(0, 0, 3, (Load(1, 0), Assign(1, "add", 1, 0, None), Store(0, 1))),)
    before = canonical_loops(simplify(lower(program)))
    (loop,) = find_loops(before)
    peeled = simplify(peel(before, loop, 4).function)
    assert len(peeled.blocks) == 1
    demand_same(before, peeled, tries=2)
