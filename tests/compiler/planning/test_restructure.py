"""Other loops mean what the source's mean, whatever the search chooses."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral.nests import random_nest
from tests.ssa.polyhedral.test_generate import demand_same
from vividc import arch
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.dfg.pipeline import PassOptions
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.tidy import tidy

MACHINE = arch.load("vivid-tile")


def restructured(function: Function) -> list[Function]:
    """What the nests of a function become: what is chosen, and what is kept in reserve."""
    plan = choose(function, Estimator(MACHINE, PassOptions()), LoopOptions(restructure=True))
    stages = [s for s in plan.stages if s.decision and s.decision.kind == "restructuring"]
    return [stage.state.function for stage in stages]


@vividc.kernel("void(int32[:, ::1])")
def third_row_before(a):
    """Two rows may run together, and three; four may not."""
    for i in range(3, a.shape[0]):
        for j in range(a.shape[1] - 1):
            a[i, j] += a[i - 3, j + 1] * np.int32(3)


def test_no_more_iterations_run_together_than_may() -> None:
    function = third_row_before.lower()
    found = restructured(function)
    assert found
    for made in found:
        old, new = (np.arange(13 * 9, dtype=np.int32).reshape(13, 9) for _ in range(2))
        interpret(function, old)
        interpret(made, new)
        assert np.array_equal(old, new)


def demand_choices_mean_the_same(seed: int) -> None:
    function = tidy(random_nest(seed))
    for made in restructured(function):
        demand_same(function, made, f"seed {seed}")


@pytest.mark.parametrize("seed", range(4))
def test_random_nests(seed: int) -> None:
    demand_choices_mean_the_same(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 100))
def test_more_random_nests(seed: int) -> None:
    demand_choices_mean_the_same(seed)
