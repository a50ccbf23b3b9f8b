"""Loads of fixed addresses before a loop: which move, and that the loop means the same."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.hoist_loads import hoist_loads


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, hoist_loads)
