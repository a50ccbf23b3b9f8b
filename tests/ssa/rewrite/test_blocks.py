"""Straight chains of blocks are one block."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.blocks import merge_chains


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, merge_chains)
