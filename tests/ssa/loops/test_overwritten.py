"""Loops go that store what is overwritten before it is read."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.loops.overwritten import without_overwritten


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, without_overwritten)
