"""One instruction stays for each value that dominates its uses."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.number_values import number_values


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, number_values)
