"""Which loops get partial results, and what they compute."""

from __future__ import annotations

import numpy as np

import vividc
from tests.compiler.planning.test_choose import MACHINE, made
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimate, Estimator, RegionCost, Shape
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan
from vividc.dfg.pipeline import PassOptions


@vividc.kernel("void(float32[::1], float32[::1])")
def chained(x, y):
    """Sums of growing parts of an array, each of which needs the ones before."""
    for i in range(len(y)):
        total = np.float32(1.0)
        for k in range(i):
            total += x[k] * y[k]
        y[i] = total


def plan(*, reassociate: bool) -> Plan:
    options = PassOptions(contract=False, reassociate=reassociate)
    return choose(chained.lower(), Estimator(MACHINE, options), LoopOptions(restructure=False))


def test_short_sums_have_partial_results_only_where_floats_may_be_reassociated() -> None:
    assert "partial results" not in {one.kind for one in plan(reassociate=False).decisions}
    [(kind, factor)] = made(plan(reassociate=True).stages[-1])
    assert (kind, factor >= 4) == ("partial results", True)


def test_what_they_compute_is_as_near_as_sums_in_order() -> None:
    x = np.random.default_rng(0).random(21, dtype=np.float32) / np.float32(21.0)
    loops = vividc.LoopOptions(restructure=False)
    strict, free = (
        vividc.compile(chained, reassociate=any_order, loops=loops) for any_order in (False, True)
    )
    here, there, right = (np.zeros(21, np.float32) for _ in range(3))
    cycles = [vividc.simulate(p, x, y).cycles for p, y in ((strict, here), (free, there))]
    chained(x, right)
    assert cycles[1] < 0.8 * cycles[0]
    assert np.allclose(there, right, rtol=1e-5)


@vividc.kernel("void(float32[::1], float32[::1])")
def copied(x, y):
    """Copies of growing parts of an array, each entered anew."""
    for k in range(len(y)):
        for i in range(k):
            y[i] = x[i]
        x[k] = y[k] + np.float32(1.0)


def test_short_loops_that_fill_no_cycle_are_unrolled_with_masks() -> None:
    loops = vividc.LoopOptions(restructure=False)
    plan = choose(copied.lower(), Estimator(MACHINE, PassOptions()), loops)
    [(kind, factor)] = made(plan.stages[-1])
    assert (kind, factor >= 2) == ("masked unrolling", True)
    program = vividc.compile(copied, loops=loops)
    plain = vividc.compile(copied, loops=vividc.LoopOptions(auto=False))
    for length in range(1, 12):
        x = np.arange(length, dtype=np.float32)
        arguments = [(x.copy(), np.zeros(length, np.float32)) for _ in range(3)]
        cycles = [
            vividc.simulate(p, *a).cycles
            for p, a in zip((program, plain), arguments[:2], strict=True)
        ]
        copied(*arguments[2])
        assert all(np.array_equal(a, b) for a, b in zip(arguments[0], arguments[2], strict=True))
    assert cycles[0] < cycles[1]


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def of_known_length(a, x):
    for i in range(a.shape[0]):
        for j in range(128):
            x[j] = a[i, j]


def test_loops_of_known_length_need_no_masks() -> None:
    loops = vividc.LoopOptions(restructure=False)
    plan = choose(of_known_length.lower(), Estimator(MACHINE, PassOptions()), loops)
    kinds = {one.kind for one in plan.decisions}
    assert "unrolling" in kinds
    assert "masked unrolling" not in kinds


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def rows(a, x, y):
    """Sums of rows, which run together, begin with 0 and are left to what follows."""
    for i in range(a.shape[0]):
        y[i] = np.float32(0.0)
        for j in range(a.shape[1]):
            y[i] += a[i, j] * x[j]


def test_sums_that_run_together_have_partial_results_too() -> None:
    options = PassOptions(reassociate=True)
    plan = choose(rows.lower(), Estimator(MACHINE, options), LoopOptions())
    tried = [one for one in plan.decisions if one.kind == "partial results"]
    assert any(one.after is not None for one in tried)


def test_reassociated_loops_of_few_operations_may_fill_more_slots() -> None:
    def largest(operations: int, reassociate: bool) -> int:
        loop = RegionCost("b", "loop", Shape(18, 20, operations), 1.0, 16.0)
        estimator = Estimator(MACHINE, PassOptions(reassociate=reassociate))
        return estimator.largest_loop(Estimate(320.0, (loop,)))

    assert largest(160, False) == largest(160, True) == 0
    assert (largest(190, False), largest(190, True)) == (190, 0)
    assert largest(200, True) == 200
