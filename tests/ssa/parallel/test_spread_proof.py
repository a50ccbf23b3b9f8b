"""What a loop over prange leaves, and the kernel's own arrays that its iterations write."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.errors import KernelError
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_parallel_loop


def run(function: Function) -> str:
    try:
        return f"returns {cut_parallel_loop(function, [2])[1].result}"
    except KernelError as refusal:
        return str(refusal).replace("\n", " / ")


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
