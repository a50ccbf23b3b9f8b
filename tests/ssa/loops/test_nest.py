"""Nests whose rows may share the inner loop, and dependences that forbid it."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at
from vividc.ssa.ir import Function
from vividc.ssa.loops.nest import find_nest, forbids_jam
from vividc.ssa.rewrite.refusal import Refusal


def run(function: Function, header: str, factor: str) -> str:
    nest = find_nest(function, loop_at(function, header))
    refused = nest if isinstance(nest, Refusal) else forbids_jam(nest, int(factor))
    return "may be jammed" if refused is None else refused.reason


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
