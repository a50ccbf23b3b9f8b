"""Fused products."""

from __future__ import annotations

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases
from vividc.dfg.passes import contract_fma


@cases(__file__)
def test_rules(case: Case) -> None:
    GRAPHS.check(case, contract_fma, same=False)
