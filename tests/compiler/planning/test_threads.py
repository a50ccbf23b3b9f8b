"""When iterations of a loop over `prange` run as threads."""

from __future__ import annotations

import numpy as np
from numba import prange

import vividc
from vividc import arch
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan
from vividc.dfg.pipeline import PassOptions
from vividc.ssa.flow import find_loops
from vividc.ssa.parallel.independent import meeting_array
from vividc.ssa.rewrite.tidy import tidy

ESTIMATOR = Estimator(arch.load("vivid-tile"), PassOptions(contract=False))


@vividc.kernel("void(float32[::1], int32, int32[::1])")
def orbits(c, limit, counts):
    for i in prange(len(c)):
        x = np.float32(0)
        count = np.int32(0)
        while count < limit:
            if x > np.float32(4):
                break
            x = x * x + c[i]
            count += 1
        counts[i] = count


def plan(options: LoopOptions, lines: frozenset[int]) -> Plan:
    return choose(orbits.lower(), ESTIMATOR, options, lines)


def kinds(made: Plan) -> list[tuple[str, int]]:
    return [
        (stage.decision.kind, stage.decision.factor)
        for stage in made.stages
        if stage.decision is not None
    ]


def test_threads_are_chosen_where_a_loop_waits_for_itself() -> None:
    made = plan(LoopOptions(), orbits.prange_lines)
    assert kinds(made)[0] in {("threads", 4), ("threads", 8)}
    assert made.stages[-1].estimate.cycles < made.stages[0].estimate.cycles / 2


def test_a_loop_over_range_has_no_threads() -> None:
    assert ("threads", 4) not in kinds(plan(LoopOptions(), frozenset()))


def test_one_thread_leaves_the_loop_alone() -> None:
    made = plan(LoopOptions(threads=1), orbits.prange_lines)
    assert not any(kind == "threads" for kind, _ in kinds(made))


def test_threads_that_are_asked_for_are_made_without_other_transformations() -> None:
    made = plan(LoopOptions(auto=False, threads=3), orbits.prange_lines)
    assert kinds(made) == [("threads", 3)]
    assert made.asked == 1


@vividc.kernel("void(int32[::1], int32[::1], int32[:, ::1], int32)")
def places(x, y, z, k):
    for i in prange(len(x)):
        y[3 * i + 1] = x[i]
        y[3 * i] = x[i] + y[3 * i + 1]
        for j in range(z.shape[1]):
            z[i, j] = x[j] * k


@vividc.kernel("void(int32[::1], int32[::1])")
def counted_in_bins(x, bins):
    for i in prange(len(x)):
        bins[x[i]] += 1


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def overlapping(x, y, n):
    for i in prange(n):
        y[2 * i] = x[i]
        y[2 * i + 2] = x[i]


@vividc.kernel("void(int32[::1])")
def next_one(x):
    for i in prange(len(x) - 1):
        x[i + 1] = x[i]


def meeting(kernel: vividc.KernelFunction) -> str | None:
    function = tidy(kernel.lower())
    return meeting_array(function, find_loops(function)[-1].header)


def test_iterations_that_write_elements_of_their_own() -> None:
    assert meeting(places) is None
    assert meeting(orbits) is None


def test_iterations_that_may_meet_get_no_threads_unasked() -> None:
    assert meeting(counted_in_bins) == "bins"
    assert meeting(overlapping) == "y"
    assert meeting(next_one) == "x"
    function = counted_in_bins.lower()
    made = choose(function, ESTIMATOR, LoopOptions(), counted_in_bins.prange_lines)
    assert not any(kind == "threads" for kind, _ in kinds(made))
    (said,) = [d.reason for d in made.decisions if d.kind == "threads"]
    assert said == "iterations may meet in bins: ask for threads if they do not"
