"""Arrays between nests go where their elements may be computed again."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.loops.temporaries import without_temporaries


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, without_temporaries)
