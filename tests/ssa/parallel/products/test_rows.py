"""Flat indices of matrices as subscripts."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.ir import Function
from vividc.ssa.parallel.products.rows import with_rows


def run(function: Function) -> object:
    made, lengths = with_rows(function)
    return (made, *(f"{array}: {size}" for array, size in lengths)) if lengths else made


@cases(__file__)
def test_rules(case: Case) -> None:
    """Pitches are what a launch makes them."""
    FUNCTIONS.check(case, run, same=False)
