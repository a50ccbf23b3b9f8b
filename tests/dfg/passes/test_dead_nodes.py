"""Dead nodes go, effects and their order stay."""

from __future__ import annotations

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases
from vividc.dfg.passes import remove_dead_nodes


@cases(__file__)
def test_rules(case: Case) -> None:
    GRAPHS.check(case, remove_dead_nodes)
