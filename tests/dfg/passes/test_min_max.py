"""Minima and maxima."""

from __future__ import annotations

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases
from vividc.dfg.passes import recognize_min_max


@cases(__file__)
def test_rules(case: Case) -> None:
    GRAPHS.check(case, recognize_min_max)
