"""Loops that test for the next iteration at the end of this one."""

from __future__ import annotations

from hypothesis import given, settings

from tests.programs import lower, nests
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same, loop_at
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.flatten.rotate import rotate
from vividc.ssa.rewrite.tidy import tidy


def run(function: Function, header: str, around: str) -> Function:
    return rotate(function, loop_at(function, header), loop_at(function, around))


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


@settings(max_examples=60)
@given(nests())
def test_programs_mean_the_same(program: tuple[object, ...]) -> None:
    before = tidy(lower(program))
    loops = find_loops(before)
    for loop in loops:
        after = rotate(before, loop, loops[-1])
        assert check_function(after) == []
        demand_same(before, after, tries=2)
