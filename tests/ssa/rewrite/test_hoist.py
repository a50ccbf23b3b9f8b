"""What does not change in a loop is computed before it."""

from __future__ import annotations

from hypothesis import given, settings

from tests.programs import lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same
from vividc.ssa.check import check_function
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.normalize import canonical_loops


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, hoist_invariants)


@settings(max_examples=30)
@given(programs())
def test_programs_mean_the_same(program: tuple[object, ...]) -> None:
    before = canonical_loops(lower(program))
    after = hoist_invariants(before)
    assert check_function(after) == []
    demand_same(before, after, tries=2)
