"""Loops go on behind errors of the simulation."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.ir import Function
from vividc.ssa.parallel.going_on import going_on


def run(function: Function) -> Function:
    return going_on(function)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run, same=False)  # an error ends what ran on
