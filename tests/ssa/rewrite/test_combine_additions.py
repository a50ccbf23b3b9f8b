"""Additions of constants in a row become one."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.combine_additions import combine_additions


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, combine_additions)
