"""Every transformation of every loop of random programs keeps what they mean, several in a row;
what does not pay is foreseen.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vividc
from tests.dfg.cut.test_build import meaning, memory_after
from tests.programs import CELLS, Nest, affine_nests, lower, programs
from vividc import arch
from vividc.compiler.planning.candidates import Candidate, Kind, apply
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.gains import GAIN, in_vain
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Draft
from vividc.compiler.planning.state import State
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.tidy import tidy

KINDS: tuple[Kind, ...] = (
    "full unrolling",
    "unrolling",
    "masked unrolling",
    "unroll-and-jam",
    "partial results",
)
choices = st.lists(
    st.tuples(st.sampled_from(KINDS), st.integers(0, 5), st.sampled_from([2, 4])), max_size=3
)


def transformed(function: Function, wanted: list[tuple[Kind, int, int]]) -> State:
    tidied = tidy(function)
    state = State(tidied, expected_trips(tidied, {}))
    for kind, which, factor in wanted:
        loops = find_loops(state.function)
        if not loops:
            break
        header = loops[which % len(loops)].header
        trips = expected_trips(state.function, state.hints)
        done = apply(state, Candidate(kind, header, factor), trips)
        if isinstance(done, State):
            assert check_function(done.function) == []
            assert {loop.header for loop in find_loops(done.function)} >= (
                done.made - state.made
            ) & {block.name for block in done.function.blocks}
            state = done
    return state


@settings(max_examples=80)
@given(programs(), choices)
def test_random_programs(program: tuple[object, ...], wanted: list[tuple[Kind, int, int]]) -> None:
    state = transformed(lower(program), wanted)
    kernel = build_kernel(state.function)
    assert memory_after(kernel) == meaning(program)
    assert memory_after(optimize_kernel(kernel)) == meaning(program)


@settings(max_examples=80)
@given(affine_nests(), choices)
def test_random_nests(nest: Nest, wanted: list[tuple[Kind, int, int]]) -> None:
    kernel = build_kernel(transformed(lower(nest.program), wanted).function)
    assert memory_after(kernel, CELLS) == meaning(nest.program, CELLS)


@vividc.kernel(f"void({', '.join(['float32[:, ::1]'] * 4)})")
def sums(a, b, c, d):
    """Recurrences that no unrolling shortens."""
    for i in range(1, a.shape[0]):
        for j in range(1, a.shape[1]):
            a[i, j] += a[i - 1, j - 1] * a[i, j - 1]
    for i in range(1, b.shape[0]):
        for j in range(1, b.shape[1]):
            b[i, j] += b[i - 1, j - 1] * b[i, j - 1]
    for i in range(1, c.shape[0]):
        for j in range(1, c.shape[1]):
            c[i, j] += c[i - 1, j - 1] * c[i, j - 1]
    for i in range(1, d.shape[0]):
        for j in range(1, d.shape[1]):
            d[i, j] += d[i - 1, j - 1] * d[i, j - 1]


def draft(kernel: vividc.KernelFunction) -> Draft:
    estimator = Estimator(arch.load("vivid-tile"), PassOptions())
    function = tidy(kernel.lower())
    made = Draft(estimator, LoopOptions(), [])
    made.start(State(function, expected_trips(function, {})))
    return made


def inner(of: Draft) -> list[str]:
    function = of.now.state.function
    return [loop.header for loop in find_loops(function) if loop.header not in of.outermost()]


def test_a_candidate_in_vain_is_foreseen_from_its_nest_alone() -> None:
    of = draft(sums)
    assert len(inner(of)) == 4
    for header in inner(of):
        candidate = Candidate("masked unrolling", header, 2)
        foreseen = of.foreseen(of.now, candidate, 0.9, 1000)
        assert foreseen is not None
        state = of.applied(of.now.state, candidate)
        assert isinstance(state, State)
        whole = of.estimator.estimate(state.function, state.hints)
        assert foreseen.cycles == pytest.approx(whole.cycles, rel=0.01)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1])")
def rows(a, b, c):
    """A loop of much work, a sum that may be in parts, and a loop of little work."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            x = a[i, j]
            for _ in range(6):
                x = x * x + x * np.float32(0.5)
            b[i, j] = x
        for j in range(a.shape[1]):
            total += b[i, j]
        c[i] = total
        for j in range(a.shape[1]):
            b[i, j] = a[i, j]


@pytest.mark.parametrize("kernel", [sums, rows], ids=["sums", "rows"])
def test_what_is_not_made_as_it_would_not_pay_does_not_pay(kernel: vividc.KernelFunction) -> None:
    of = draft(kernel)
    before, left_out, made = of.now.estimate.cycles, 0, 0
    kinds: tuple[Kind, ...] = ("masked unrolling", "partial results")
    for header, kind, factor in product(inner(of), kinds, (2, 4)):
        candidate = Candidate(kind, header, factor)
        state = of.applied(of.now.state, candidate)
        if isinstance(state, State):
            after = of.estimator.estimate(state.function, state.hints).cycles
            is_left_out = bool(in_vain(of.estimator, of.now, candidate, 1000))
            assert not is_left_out or after > GAIN[kind] * before
            left_out, made = left_out + is_left_out, made + (not is_left_out)
    assert left_out
    assert made or kernel is sums


def test_what_may_pay_is_not_foreseen() -> None:
    of = draft(sums)
    candidate = Candidate("masked unrolling", inner(of)[0], 2)
    assert of.foreseen(of.now, candidate, 1.5, 1000) is None


def test_a_nest_that_takes_less_than_it_would_have_to_save_is_left_alone() -> None:
    of = draft(sums)
    first, *others = inner(of)
    trips = {first: 1e5, **dict.fromkeys(others, 10.0)}
    options = LoopOptions(restructure=False)
    plan = choose(sums.lower(), of.estimator, options, trips=trips)
    tried = {d.header: d for d in plan.decisions if d.kind == "masked unrolling"}
    assert tried[first].reason == "2 of its iterations would take 14 cycles, one takes 7"
    assert {tried[one].after for one in others} == {None}
    assert {tried[one].reason for one in others} == {"takes less than it would have to save"}
