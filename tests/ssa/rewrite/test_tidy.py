"""What every transformation ends with."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.tidy import tidy


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, tidy)
