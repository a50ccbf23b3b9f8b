"""What a loop over prange leaves, and the kernel's own arrays that its iterations write."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.errors import KernelError
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_parallel_loop


def run(function: Function) -> str:
    try:
        found = cut_parallel_loop(function, [2])[1]
    except KernelError as refusal:
        return str(refusal).replace("\n", " / ")
    sliced = "".join(f", chunks have slices of {name}" for name in found.sliced)
    return f"returns {found.result}{sliced}"


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
