"""Copies of blocks, and the function around them."""

from __future__ import annotations

from dataclasses import replace

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.edit import block_of, retarget, with_blocks
from vividc.ssa.ir import Const, Function
from vividc.ssa.rewrite.clone import clone_blocks, extend_phis, repair_uses


def run(function: Function, how: str, *words: str) -> Function:
    """With a copy of the blocks, which `b1` jumps to if it is `entered`; else nobody does."""
    names = [word for word in words if "=" not in word]
    pairs = (word.split("=") for word in words if "=" in word)
    given = {int(ident): Const(int(value)) for ident, value in pairs}
    clone = clone_blocks(function, names, given=given, stem="copy")
    made = extend_phis(function, clone)
    if how == "copied":
        return made
    first = block_of(made, "b1")
    jump = retarget(first.branch, names[0], clone.names[names[0]])
    return repair_uses(with_blocks(made, (replace(first, branch=jump),)), names, [clone])


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run, illegal="after")
