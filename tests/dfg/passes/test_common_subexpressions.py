"""Equal nodes are one."""

from __future__ import annotations

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases
from vividc.dfg.passes import eliminate_common_subexpressions


@cases(__file__)
def test_rules(case: Case) -> None:
    GRAPHS.check(case, eliminate_common_subexpressions)
