"""Every pass keeps what a graph computes, is idempotent, and leaves a legal graph."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strategies import BASES, MEMORY_WORDS, dfgs, words
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.forms.text import to_text
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.dfg.ir import DFG
from vividc.dfg.passes import (
    balance_reductions,
    contract_fma,
    eliminate_common_subexpressions,
    fold_constants,
    fold_selects,
    recognize_min_max,
    remove_dead_nodes,
)

TRIP = 5
PASSES = (
    fold_constants,
    recognize_min_max,
    expand_math,
    eliminate_common_subexpressions,
    balance_reductions,
    contract_fma,
    fold_selects,
    remove_dead_nodes,
)
EXACT = [step for step in PASSES if step is not contract_fma]


def run(dfg: DFG, memory: list[int], n: int, a: int) -> tuple[list[int], dict[str, int], int]:
    """Memory, variables and iterations after the loop."""
    scratchpad = np.array(memory, dtype=np.uint32)
    env = {**BASES, "n": n, "a": a}
    result = interpret_region(dfg, "loop", TRIP, env, scratchpad)
    return scratchpad.tolist(), dict(result.written), result.iterations


@pytest.mark.parametrize("step", EXACT, ids=lambda step: step.__name__)
@settings(max_examples=40)
@given(
    dfg=dfgs(),
    memory=st.lists(words(), min_size=MEMORY_WORDS, max_size=MEMORY_WORDS),
    n=words(),
    a=words(),
)
def test_a_pass_changes_no_result(
    step: Callable[[DFG], DFG], dfg: DFG, memory: list[int], n: int, a: int
) -> None:
    assert check(dfg) == []
    after = step(dfg)
    assert check(after) == [], to_text(after)
    assert run(after, memory, n, a) == run(dfg, memory, n, a), to_text(after)


@pytest.mark.parametrize("step", PASSES, ids=lambda step: step.__name__)
@settings(max_examples=40)
@given(dfg=dfgs())
def test_a_pass_is_idempotent(step: Callable[[DFG], DFG], dfg: DFG) -> None:
    after = step(dfg)
    assert check(after) == []
    assert step(after) is after, to_text(after)


@settings(max_examples=40)
@given(
    dfg=dfgs(),
    memory=st.lists(words(), min_size=MEMORY_WORDS, max_size=MEMORY_WORDS),
    n=words(),
    a=words(),
)
def test_all_exact_passes_in_sequence_change_no_result(
    dfg: DFG, memory: list[int], n: int, a: int
) -> None:
    after = dfg
    for step in EXACT + EXACT:
        after = step(after)
    assert check(after) == []
    assert run(after, memory, n, a) == run(dfg, memory, n, a), to_text(after)
