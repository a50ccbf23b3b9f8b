"""Loops that are canonical, closed, and left to one block; chains that are one block."""

from __future__ import annotations

from hypothesis import given, settings

from tests.programs import lower, programs
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, demand_same
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function
from vividc.ssa.rewrite import normalize as module
from vividc.ssa.rewrite.normalize import copy_exit_values, normalize


def run(function: Function, step: str) -> Function:
    return getattr(module, step)(function)


@cases(__file__)
def test_rules(case: Case) -> None:
    """Blocks that are not reached, and loops at the entry, are legal nowhere else."""
    FUNCTIONS.check(case, run, illegal="before")


@settings(max_examples=60)
@given(programs())
def test_programs_mean_the_same(program: tuple[object, ...]) -> None:
    before = lower(program)
    shaped = normalize(before)
    for after in (shaped, copy_exit_values(shaped)):
        assert check_function(after) == []
        demand_same(before, after, tries=2)
    assert normalize(shaped).blocks == shaped.blocks
