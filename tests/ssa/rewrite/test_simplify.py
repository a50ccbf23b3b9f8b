"""Simplified functions mean what they meant, and decided control flow is gone."""

from __future__ import annotations

from hypothesis import given, settings

from tests.programs import lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function
from vividc.ssa.rewrite import simplify as module
from vividc.ssa.rewrite.simplify import simplify


def run(function: Function, step: str = "simplify") -> Function:
    return getattr(module, step)(function)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


@settings(max_examples=60)
@given(programs())
def test_simplified_programs_mean_the_same(program: tuple[object, ...]) -> None:
    before = lower(program)
    after = simplify(before)
    assert check_function(after) == []
    assert simplify(after) is after
    demand_same(before, after, tries=2)
