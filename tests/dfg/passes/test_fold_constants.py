"""Constants are computed before anything runs."""

from __future__ import annotations

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases
from vividc.dfg.passes import fold_constants


@cases(__file__)
def test_rules(case: Case) -> None:
    GRAPHS.check(case, fold_constants)
