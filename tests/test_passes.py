"""Cases of passes, by the names that `vividc opt` knows them by: a new pass needs its file only."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.dfg.support import GRAPHS
from tests.rules import Case, cases_of_passes
from tests.ssa.support import FUNCTIONS
from vividc.compiler.passes import FUNCTION_PASSES, GRAPH_PASSES

TESTS = Path(__file__).parent
ROUNDS_ONCE = "contract-fma"
"""A fused product rounds once, so its words are others."""
FOUND = [
    pytest.param(name, case, id=f"{case.file.relative_to(TESTS).with_suffix('')}: {case.title}")
    for name, case in cases_of_passes(TESTS)
]


@pytest.mark.parametrize(("name", "case"), FOUND)
def test_rules(name: str, case: Case) -> None:
    """Functions that are LLVM's yet are not run: what calls do is not known."""
    same = name != ROUNDS_ONCE and ' llvm "' not in case.before
    if name in GRAPH_PASSES:
        GRAPHS.check(case, GRAPH_PASSES[name], same=same)
    else:
        FUNCTIONS.check(case, FUNCTION_PASSES[name], same=same)
