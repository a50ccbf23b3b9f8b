"""Intervals of the integers of LLVM's functions."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.frontend.ranges.known import ranges_of
from vividc.ssa.ir import Function, Ref


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


def run(function: Function) -> str:
    """A line for each block: the intervals there of what it computes and of what it reads."""
    ranges = ranges_of(function)
    lines = [""]
    for block in function.blocks:
        read = {v.id for i in block.instrs for v in i.operands if isinstance(v, Ref)}
        idents = sorted(read | {item.id for item in block.items})
        texts = (f"%{n} {list(ranges.at(Ref(n), block.name))}" for n in idents)
        lines.append(f"{block.name}: {', '.join(texts) or 'nothing'}")
    return "\n".join(lines)
