"""Loops directly inside a parallel one go from one input to another."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.ir import Function
from vividc.ssa.parallel.blocks import blocked


def run(function: Function) -> object:
    made, bounds = blocked(function, "b1")
    return (made, *(f"from {first} to {limit}" for first, limit in bounds)) if bounds else made


@cases(__file__)
def test_rules(case: Case) -> None:
    """The function computes a block: not what it computed."""
    FUNCTIONS.check(case, run, same=False)
