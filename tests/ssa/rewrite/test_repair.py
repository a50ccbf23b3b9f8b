"""Uses read the definition that reaches them."""

from __future__ import annotations

import pytest

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, function
from vividc.errors import InternalError, SourceLoc
from vividc.machine.opcodes import Type
from vividc.ssa.ir import Function, Ref
from vividc.ssa.rewrite.repair import repair


def run(given: Function, ident: str, *definitions: str) -> Function:
    ends = dict(one.split("=") for one in definitions)
    values = {block: Ref(int(value)) for block, value in ends.items()}
    return repair(given, int(ident), Type.I32, values, SourceLoc("f.py", 9))


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run, same=False)


def test_a_use_that_no_definition_reaches_is_a_defect_of_ours() -> None:
    given = function('b0:\n  jump b1\nb1:\n  %0 i32 = add $"n", 0x1\n  return %0\n')
    with pytest.raises(InternalError, match="value 0 is used where no definition reaches"):
        repair(given, 0, Type.I32, {})
