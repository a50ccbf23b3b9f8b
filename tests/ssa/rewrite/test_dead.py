"""What nothing reads goes."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.rewrite.dead import remove_unused


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, remove_unused, same="llvm" not in case.before)
