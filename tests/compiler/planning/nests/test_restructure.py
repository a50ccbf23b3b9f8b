"""Other loops mean what the source's mean, whatever the search chooses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import float32

import vividc
from tests.ssa.polyhedral.nests import SIDE, random_nest
from tests.ssa.polyhedral.test_generate import demand_same
from vividc import arch
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.nests.factors import are_past_the_best, crowded, more
from vividc.compiler.planning.nests.parts import expected_lengths, static_part
from vividc.compiler.planning.nests.trees import Trees
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.state import State
from vividc.dfg.pipeline import PassOptions
from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.frequency import NO_TRIPS, expected_trips
from vividc.ssa.flow import find_loops, pipelined_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

MACHINE = arch.load("vivid-tile")


def restructured(function: Function) -> list[Function]:
    """What the nests of a function become: what is chosen, and what is kept in reserve."""
    plan = choose(function, Estimator(MACHINE, PassOptions()), LoopOptions(restructure=True))
    stages = [s for s in plan.stages if s.decision and s.decision.kind == "restructuring"]
    return [stage.state.function for stage in stages]


def skewed(apart: int, aside: int) -> Function:
    """Each element of `b` is twice one some rows above and some columns aside, and one more."""
    first, limit = max(-aside, 0), SIDE - max(aside, 0)

    @vividc.kernel("void(int32[::1], int32[:, ::1], int32)")
    def nest(a, b, n):
        for i in range(apart, b.shape[0]):
            for j in range(first, limit):
                b[i, j] = 2 * b[i - apart, j + aside] + 1

    return tidy(nest.lower())


@pytest.mark.parametrize(("apart", "aside"), [(2, 1), (3, 1), (3, -2), (5, 1), (1, 1)])
def test_iterations_some_apart_are_not_jammed_across(apart: int, aside: int) -> None:
    """Groups of two do not meet a dependence over three iterations, groups of four do."""
    function = skewed(apart, aside)
    found = restructured(function)
    assert found
    for made in found:
        demand_same(function, made, f"{apart} apart, {aside} aside")


@vividc.kernel("void(int32, float32[::1], float32[::1])")
def means(steps, a, b):
    """Of three neighbours, entered often."""
    for _ in range(steps):
        for i in range(1, len(a) - 1):
            b[i] = a[i - 1] + a[i] + a[i + 1]
        for i in range(1, len(a) - 1):
            a[i] = b[i - 1] + b[i] + b[i + 1]


def test_groups_share_elements_at_their_ends_though_what_they_lack_is_masked() -> None:
    made = restructured(tidy(means.lower()))[-1]
    for loop in pipelined_loops(made):
        inside = [i.op for b in made.blocks if b.name in loop.blocks for i in b.instrs]
        assert inside.count(Opcode.LOAD) == inside.count(Opcode.STORE)


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1])")
def filtered(a, taps, b):
    for y in range(b.shape[0]):
        for x in range(b.shape[1]):
            total = float32(0.0)
            for t in range(taps.shape[0]):
                total += a[y, x + t] * taps[t]
            b[y, x] = total


def test_one_loop_of_a_tile_is_masked_where_elements_along_the_other_are_carried() -> None:
    """Rows that do not fill a tile take one more, and not a loop each; of the columns next to each
    other, whose loads in common could not be carried under masks of theirs, one loads.
    """
    made = restructured(tidy(filtered.lower()))[-1]
    full, rest = (
        [i.op for b in made.blocks if b.name in loop.blocks for i in b.instrs]
        for loop in pipelined_loops(made)
    )
    rows = full.count(Opcode.LOAD) - 1  # and a tap
    assert full.count(Opcode.FMUL) >= 4 * rows >= 16
    assert rest.count(Opcode.FMUL) == rows == rest.count(Opcode.LOAD) - 1


@vividc.kernel("void(int32[::1], int32[:, ::1], int32)")
def intervals(a, b, n):
    """Each interval takes the most that its halves, or what is inside it, make; sums are int64."""
    for i in range(b.shape[0] - 1, -1, -1):
        for j in range(i + 1, b.shape[0]):
            if i + 1 < j:
                b[i, j] = max(b[i, j], b[i + 1, j - 1] + a[j])
            else:
                b[i, j] = max(b[i, j], a[i])
            for k in range(i + 1, j):
                b[i, j] = max(b[i, j], b[i, k] + b[k + 1, j])


@pytest.mark.slow
def test_intervals_of_one_length_are_jammed_though_a_branch_tells_the_shortest() -> None:
    function = tidy(intervals.lower())
    found = restructured(function)
    assert found
    for made in found:
        demand_same(function, made, "intervals")
    sums = [
        sum(i.op is Opcode.LOAD for b in found[-1].blocks if b.name in o.blocks for i in b.instrs)
        for o in find_loops(found[-1])
    ]
    assert max(sums) >= 8  # four intervals at a time, two loads of each


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


@pytest.mark.parametrize(
    ("cycles", "between"),
    [
        ({4: 10.0, 2: 12.0, 8: math.inf}, [6]),
        ({4: 10.0, 8: math.inf}, [2]),
        ({4: 10.0, 2: 12.0, 8: math.inf, 6: math.inf}, [5]),
        ({4: 10.0, 8: math.inf, 6: 9.0}, [7]),
        ({4: 10.0, 8: math.inf, 5: 9.0, 6: math.inf}, []),
        ({4: 10.0, 8: 9.0}, []),
        ({4: math.inf, 2: math.inf}, []),
    ],
)
def test_a_factor_half_way_to_one_that_is_not_possible_is_tried(
    cycles: dict[int, float], between: list[int]
) -> None:
    found = more({(factor,): taken for factor, taken in cycles.items()}, (4,))
    assert [factor for (factor,) in found] == between


def test_of_a_pair_smaller_ones_are_tried_where_larger_ones_fail() -> None:
    cycles = {(4, 4): 10.0, (4, 8): 11.0, (8, 4): math.inf, (5, 8): 12.0}
    assert more(cycles, (4, 4)) == [(1, 4), (4, 1), (2, 2)]
    cycles |= {(1, 4): math.inf, (2, 2): 12.0}
    assert more(cycles, (4, 4)) == [(4, 1)]
    assert more({**cycles, (4, 1): 9.0}, (4, 4)) == []


def test_large_tiles_are_much_better_or_left_out() -> None:
    assert crowded({(4, 4): 10.0, (8, 4): 8.0, (8, 5): 7.3}) == [(8, 5)]
    assert crowded({(4, 4): 10.0, (8, 4): 8.0, (8, 5): 7.1}) == []
    assert crowded({(4, 4): 10.0, (16,): 1.0}) == []


@vividc.kernel("void(int32[:, ::1], int32[:, ::1])")
def blurred(a, b):
    """Rows that run together share sums of three elements; columns do not."""
    for y in range(1, a.shape[0] - 1):
        for x in range(1, a.shape[1] - 1):
            top = a[y - 1, x - 1] + 2 * a[y - 1, x] + a[y - 1, x + 1]
            middle = a[y, x - 1] + 2 * a[y, x] + a[y, x + 1]
            bottom = a[y + 1, x - 1] + 2 * a[y + 1, x] + a[y + 1, x + 1]
            b[y, x] = np.int32(top + 2 * middle + bottom + 8) >> 4


def test_an_order_that_is_nearly_the_best_at_first_is_given_its_best_factors() -> None:
    function = tidy(blurred.lower())
    made = restructured(function)[-1]
    image = np.arange(13 * 12, dtype=np.int32).reshape(13, 12) ** 2 % 251
    expected, found = np.zeros_like(image), np.zeros_like(image)
    interpret(function, image, expected)
    interpret(made, image, found)
    assert np.array_equal(expected, found)
    [loop] = pipelined_loops(made)
    inside = [i.op for b in made.blocks if b.name in loop.blocks for i in b.instrs]
    assert inside.count(Opcode.STORE) == 8


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def recurrent_rows(x, y):
    for i in range(x.shape[0]):
        for j in range(1, x.shape[1]):
            y[i, j] = (x[i, j] - y[i, j - 1]) / x[0, j]


@pytest.mark.parametrize(("constants", "rows"), [(32, {4}), (2, {1}), (1, set())])
def test_rows_are_no_more_than_constant_stores_have_addresses_for(
    constants: int, rows: set[int]
) -> None:
    pes = tuple(replace(pe, constants=constants) for pe in MACHINE.pes)
    estimator = Estimator(replace(MACHINE, pes=pes), PassOptions())
    function = tidy(recurrent_rows.lower())
    stages = choose(function, estimator, LoopOptions(restructure=True)).stages
    made = [s for s in stages if s.decision and s.decision.kind == "restructuring"]
    assert {s.decision.factor for s in made if s.decision} == rows
    assert all(s.estimate.entries <= 0.6 * estimator.entries for s in made)


def test_larger_factors_are_not_tried_where_smaller_ones_are_better() -> None:
    cycles = {(4, 4): 110.0, (1, 4): 200.0, (4, 1): 100.0}
    assert are_past_the_best(cycles, (4, 4))
    assert not are_past_the_best({**cycles, (4, 4): 104.0}, (4, 4))
    assert not are_past_the_best(cycles, (4, 1))  # the smaller one of its columns is none of it
    assert not are_past_the_best(cycles, (2, 2))


def test_groups_of_loops_are_given_factors_after_all_trees_of_orders() -> None:
    function = tidy(blurred.lower())
    header = next(loop.header for loop in find_loops(function) if len(loop.blocks) > 3)
    estimator = Estimator(arch.load("vivid-tile"), PassOptions(contract=True))
    state = State(function, expected_trips(function, NO_TRIPS))
    scop = static_part(state, header)
    assert not isinstance(scop, Refusal)
    trees = Trees(state, 0, scop, estimator, expected_lengths(scop, state.hints), 128, most=1)
    tree = tree_of(scop)
    assert trees.attempt(tree) is not None
    masked = replace(tree, factor=2, masked=True)
    assert trees.attempt(masked) is None
    trees.allow(1)
    assert trees.attempt(masked) is not None
