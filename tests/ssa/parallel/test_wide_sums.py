"""Sums of 64 bits in two words that iterations only add to."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at
from vividc.ssa.edit import block_of
from vividc.ssa.ir import Function
from vividc.ssa.parallel.wide_sums import is_wide_sum


def run(function: Function) -> str:
    low, high = (p for p in block_of(function, "b1").phis if p.id in (40, 45))
    return "a sum" if is_wide_sum(function, loop_at(function, "b1"), low, high) else "none"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
