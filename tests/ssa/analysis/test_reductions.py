"""Scalars that iterations only add to, and how partial results are combined."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at
from vividc.ssa.analysis.reductions import reduction_of
from vividc.ssa.edit import block_of
from vividc.ssa.ir import Function


def run(function: Function) -> str:
    (phi,) = (p for p in block_of(function, "b1").phis if p.id == 40)
    found = reduction_of(function, loop_at(function, "b1"), phi)
    if found is None:
        return "none"
    how = found.how
    marks = [f"{mark} {value}" for mark, value in (("swapped", how.swapped), ("taken", how.taken))]
    identity = "alike" if how.identity is None else f"from {how.identity:#010x}"
    return " ".join(
        (how.op, identity, *(marks if how.taken is not None else ()), f"start {found.start}")
    )


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
