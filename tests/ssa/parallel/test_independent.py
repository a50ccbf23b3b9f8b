"""Iterations that prove to touch bytes of their own."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.ir import Function
from vividc.ssa.parallel.independent import meeting_array


def run(function: Function) -> str:
    return meeting_array(function, "b1") or "none"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
