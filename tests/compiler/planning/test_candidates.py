"""Every transformation of every loop of random programs keeps what they mean, several in a row."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.cut.test_build import meaning, memory_after
from tests.programs import CELLS, Nest, affine_nests, lower, programs
from vividc.compiler.planning.candidates import Candidate, Kind, apply
from vividc.compiler.planning.state import State
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
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
