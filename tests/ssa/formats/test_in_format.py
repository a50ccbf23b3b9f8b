"""float32 arithmetic in narrower formats: what is converted where."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.formats import FORMATS
from vividc.ssa.formats.in_format import in_format
from vividc.ssa.ir import Function


def run(function: Function, name: str) -> Function:
    return in_format(function, FORMATS[name])


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run, same=False)
