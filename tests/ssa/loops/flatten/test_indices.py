"""Indices of a loop, with what does not change in it moved into base and offset, and back."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at
from vividc.ssa.ir import Function
from vividc.ssa.loops.flatten import indices


def run(function: Function, step: str, header: str) -> Function | None:
    return getattr(indices, step)(function, loop_at(function, header))


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
