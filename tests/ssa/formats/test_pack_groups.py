"""Values that may share a word: twins by thread, or by what they compute."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.ssa.formats.pack_groups import find_groups
from vividc.ssa.ir import Function


def run(function: Function) -> str:
    groups = (
        f"{'phi' if group.opcode is None else group.opcode.value} {group.format.name}"
        f" {' '.join(f'%{member}' for member in group.members)} in {group.block}"
        for group in find_groups(function)
    )
    return "\n".join(groups) or "none"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
