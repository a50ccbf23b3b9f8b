"""Equal operations of one block merge; those of different blocks, and accesses, stay."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.number_values import merge_equal


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, merge_equal)
