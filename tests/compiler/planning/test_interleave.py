"""When iterations of any loop run side by side because a loop inside them waits."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from numba import prange

import vividc
from vividc import arch
from vividc.compiler.planning.candidates import Candidate, apply
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan
from vividc.compiler.planning.state import State
from vividc.dfg.pipeline import PassOptions
from vividc.errors import KernelError
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

ESTIMATOR = Estimator(arch.load("vivid-tile"), PassOptions(contract=False))


@vividc.kernel("void(int32[::1], int32[::1])")
def steps_to_one(x, steps):
    for i in range(len(x)):
        n = x[i]
        count = np.int32(0)
        while n > 1:
            n = n // 2 if n & 1 == 0 else 3 * n + 1
            count += 1
        steps[i] = count


@vividc.kernel("void(int32[::1], int32[::1])")
def in_one_place(x, steps):
    for i in range(len(x)):
        n = x[i]
        while n > 1:
            n = n // 2 if n & 1 == 0 else 3 * n + 1
            steps[n & 7] += 1


@vividc.kernel("void(int32[::1], int32[::1])")
def one_after_another(x, steps):
    for i in range(len(x) - 1):
        n = steps[i]
        while n > x[i]:
            n = n // 2
        steps[i + 1] = n + 100


@vividc.kernel("void(uint8[:, ::1], int32[::1], uint8[:, ::1])")
def full_rows(image, table, out):
    """No static-control part, but rows leave no PE idle."""
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            a = image[y, x]
            for _ in range(3):
                a = np.uint8(a * a + (a >> 1) + (a << 2) + table[a & 31])
            out[y, x] = a


@vividc.kernel("void(int32[::1], int32[::1])")
def promised(x, steps):
    for i in prange(len(x)):
        n = x[i]
        while n > 1:
            n = n // 2
            steps[i] = n


def plan(kernel: vividc.KernelFunction, options: LoopOptions = LoopOptions()) -> Plan:  # noqa: B008 - frozen
    return choose(kernel.lower(), ESTIMATOR, options, kernel.prange_lines)


def kinds(made: Plan) -> list[tuple[str, int]]:
    return [(s.decision.kind, s.decision.factor) for s in made.stages if s.decision is not None]


def line_of(kernel: vividc.KernelFunction, text: str) -> int:
    lines, start = inspect.getsourcelines(kernel.py_func)
    return start + next(number for number, line in enumerate(lines) if text in line)


def test_iterations_run_side_by_side_where_a_loop_waits() -> None:
    made = plan(steps_to_one)
    assert kinds(made)[-1][0] == "interleaving"
    assert made.stages[-1].estimate.cycles < made.stages[0].estimate.cycles / 2


def test_the_second_best_factor_is_in_reserve() -> None:
    before, last = plan(steps_to_one).stages[-2:]
    assert before.reserve
    assert not last.reserve
    assert before.decision is not None
    assert last.decision is not None
    assert before.decision.factor * 2 == last.decision.factor


@pytest.mark.parametrize("kernel", [in_one_place, one_after_another])
def test_iterations_that_may_meet_run_one_after_the_other(kernel: vividc.KernelFunction) -> None:
    made = plan(kernel)
    assert not any(kind == "interleaving" for kind, _ in kinds(made))
    reasons = [d.reason for d in made.decisions if d.kind == "interleaving"]
    assert reasons == ["iterations may meet in steps"]


@vividc.kernel("void(int32[::1], int32[::1], float32[::1], float32[::1], float32[::1])")
def sparse_rows(row_start, column, value, x, y):
    for i in range(len(row_start) - 1):
        total = np.float32(0.0)
        for k in range(row_start[i], row_start[i + 1]):
            total += value[k] * x[column[k]]
        y[i] = total


def test_eight_may_pay_where_two_do_not() -> None:
    """On a fabric with additions of one cycle a row alone starts an element in every one."""
    estimator = Estimator(arch.load("vivid-tile-unit"), PassOptions(contract=False))
    made = choose(sparse_rows.lower(), estimator, LoopOptions(), sparse_rows.prange_lines)
    tried = {d.factor: d for d in made.decisions if d.kind == "interleaving"}
    assert tried[2].reason == "does not pay"
    assert made.stages[-1].decision is tried[8]


def test_a_loop_that_fills_the_array_is_left_alone() -> None:
    assert not any(d.kind == "interleaving" for d in plan(full_rows).decisions)


def test_a_loop_over_prange_has_threads_or_nothing() -> None:
    assert not any(d.kind == "interleaving" for d in plan(promised).decisions)
    one = plan(promised, LoopOptions(threads=1))
    assert not any(d.kind in ("threads", "interleaving") for d in one.decisions)


def test_what_cannot_be_jammed_is_interleaved_where_the_user_asks() -> None:
    line = line_of(steps_to_one, "for i")
    asked = LoopOptions(auto=False, jam={line: 4})
    assert kinds(plan(steps_to_one, asked)) == [("interleaving", 4)]
    line = line_of(in_one_place, "for i")
    with pytest.raises(KernelError, match="unroll-and-jam by 4 is not possible here"):
        plan(in_one_place, LoopOptions(auto=False, jam={line: 4}))


def test_the_longest_of_several_iterations_is_longer_than_the_mean() -> None:
    function = tidy(steps_to_one.lower())
    state = State(function, expected_trips(function, {}))
    inner, outer = find_loops(function)
    done = apply(state, Candidate("interleaving", outer.header, 4), state.hints)
    assert not isinstance(done, Refusal)
    [header] = [new for new, old in done.origin.items() if old == inner.header]
    assert done.hints[header] == pytest.approx(1.6 * state.hints[inner.header])
