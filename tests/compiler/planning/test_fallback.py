"""Which stage of a plan is kept."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import vividc
from tests.compiler.planning.test_choose import MACHINE, plan, product
from vividc.compiler import driver, stage
from vividc.compiler.planning.estimate import Estimate, Estimator, RegionCost, Shape
from vividc.compiler.planning.fallback import Budget, Outcome, Race, settle
from vividc.compiler.planning.plan import Plan, Stage
from vividc.compiler.regions.map_regions import Unmapped
from vividc.dfg.ir import DFG
from vividc.dfg.pipeline import PassOptions
from vividc.errors import KernelError, MappingFailed, TimeLimit
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.deadline import EFFORT_SHARE, Deadline
from vividc.mapper.registry import BUILT_IN
from vividc.mapper.request import MapRequest
from vividc.mapper.search.portfolio import auto
from vividc.ssa.flow import find_loops


def fake(stage: Stage, cycles: float) -> Outcome:
    """An outcome of which only the cycles count."""
    return Outcome(stage, None, {}, None, Estimate(cycles, ()), {})  # type: ignore[arg-type]


def made(*cycles: float) -> Plan:
    """A plan whose stages are estimated so."""
    first = plan(product, auto=False).stages[0]
    return Plan(tuple(Stage(first.state, Estimate(item, ())) for item in cycles))


def hot(cycles: float, *, by_block: bool) -> Outcome:
    """An outcome of a stage with one loop, which is modulo-scheduled or not."""
    loop = RegionCost("b1", "loop", Shape(1, 10, 4), 1.0, 16.0)
    stage = replace(made(100).stages[0], estimate=Estimate(50, (loop,)))
    why = {"b1": "took too long"} if by_block else {}
    return replace(fake(stage, cycles), sequential=why)


def test_the_last_stage_that_is_as_good_as_estimated_is_kept() -> None:
    stages = made(100, 50, 25)
    settled = settle(stages, lambda stage, *_: fake(stage, stage.estimate.cycles + 5))
    assert settled.index == 2
    assert settled.dropped == {}


def test_a_stage_that_does_not_map_gives_way_to_the_one_before() -> None:
    stages = made(100, 50, 25)

    def attempt(stage: Stage, *_: object) -> Outcome:
        if stage is stages.stages[2]:
            raise TimeLimit("too slow")
        return fake(stage, stage.estimate.cycles)

    settled = settle(stages, attempt)
    assert settled.index == 1
    assert "too slow" in settled.dropped[2]


def test_a_kernel_that_only_a_late_stage_could_save_is_refused_with_a_longer_time_limit() -> None:
    stages = made(100, 50)

    def attempt(stage: Stage, *_: object, late: bool) -> Outcome:
        if stage is stages.stages[1] and late:
            raise TimeLimit("too slow")
        raise KernelError("needs 600 contexts", hint="split the kernel")

    for late, hint in ((True, "--time-limit"), (False, "split the kernel")):
        with pytest.raises(KernelError, match="needs 600 contexts") as caught:
            settle(stages, partial(attempt, late=late))
        assert hint in str(caught.value)


def test_a_reserve_is_mapped_if_the_stage_after_it_is_not_or_comes_out_slower() -> None:
    first, reserve, best = made(100, 24, 25).stages
    stages = Plan((first, replace(reserve, reserve=True), best))
    assert settle(stages, lambda stage, *_: fake(stage, stage.estimate.cycles)).index == 2

    def attempt(stage: Stage, *_: object) -> Outcome:
        if stage is best:
            raise TimeLimit("too many contexts")
        return fake(stage, stage.estimate.cycles)

    assert settle(stages, attempt).index == 1
    for achieved, index in ((26, 2), (40, 1)):
        came_out = {id(best): achieved, id(stages.stages[1]): 24, id(first): 100}
        settled = settle(
            stages, lambda stage, *_, came_out=came_out: fake(stage, came_out[id(stage)])
        )
        assert settled.index == index


def test_a_stage_that_turns_out_slower_gives_way() -> None:
    stages = made(100, 50, 25)
    achieved = {id(stages.stages[2]): 80.0, id(stages.stages[1]): 50.0}
    settled = settle(stages, lambda stage, *_: fake(stage, achieved.get(id(stage), 100.0)))
    assert settled.index == 1
    assert "slower" in settled.dropped[2]


def test_a_stage_before_that_is_not_better_after_all_is_not_taken() -> None:
    stages = made(100, 50)
    achieved = {id(stages.stages[1]): 110.0}
    settled = settle(stages, lambda stage, *_: fake(stage, achieved.get(id(stage), 120.0)))
    assert settled.index == 1


def test_what_the_user_asks_for_need_not_pay() -> None:
    stages = replace(made(100, 200), asked=1)
    settled = settle(stages, lambda stage, *_: fake(stage, stage.estimate.cycles))
    assert settled.index == 1


def test_the_kernel_as_written_is_the_last_resort() -> None:
    def attempt(stage: Stage, last_resort: bool, _: float) -> Outcome:
        raise MappingFailed("last" if last_resort else "transformed")

    with pytest.raises(MappingFailed, match="last"):
        settle(made(100, 50), attempt)


def test_a_transformed_loop_without_a_mapping_leaves_a_modulo_schedule(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The kernel as written still pipelines: it does not run block by block."""
    real = stage.map_kernel

    written = {loop.header for loop in find_loops(product.lower())}

    def fails_if_restructured(kernel, *rest, **options):  # type: ignore[no-untyped-def]
        headers = [region.header for region in kernel.regions if region.kind == "loop"]
        made = tuple(header for header in headers if header not in written)
        return Unmapped(made, TimeLimit("no time")) if made else real(kernel, *rest, **options)

    monkeypatch.setattr(stage, "map_kernel", fails_if_restructured)
    program = driver.compile(product, MACHINE)
    assert [region.kind for region in program.regions].count("loop") == 1
    reasons = [item.reason for loop in program.loops for item in loop.transforms]
    assert any("no time" in reason for reason in reasons)


def test_a_hot_loop_block_by_block_never_beats_a_mapped_one() -> None:
    """Whatever the trips that are assumed say of the two."""
    outcomes = {1: hot(20, by_block=True), 0: hot(300, by_block=False)}
    stages = made(100, 50)
    settled = settle(stages, lambda stage, *_: outcomes[stages.stages.index(stage)])
    assert settled.index == 0
    outcomes = {1: hot(300, by_block=False), 0: hot(20, by_block=True)}
    settled = settle(stages, lambda stage, *_: outcomes[stages.stages.index(stage)])
    assert settled.index == 1


def test_a_stage_is_asked_to_take_less_than_the_best_so_far() -> None:
    """One that is sure not to is not kept, and those before it may be better yet."""
    stages = made(60, 55, 50)
    asked: list[float] = []

    def attempt(stage: Stage, _: bool, below: float) -> Outcome | None:
        asked.append(below)
        return None if len(asked) == 2 else fake(stage, 70.0 / len(asked))

    settled = settle(stages, attempt)
    assert asked == [math.inf, 70.0, 70.0]
    assert settled.index == 0
    assert list(settled.dropped) == [2]


def test_a_race_is_lost_by_the_bounds_of_what_is_not_mapped_yet() -> None:
    estimator = Estimator(MACHINE, PassOptions(False))
    stage = plan(product, auto=False).stages[0]
    hints = stage.state.hints
    function = estimator.prepared(stage.state.function, hints)
    kernel = estimator.built(function)
    least = stage.estimate.least
    [loop] = [i for i, region in enumerate(kernel.regions) if region.kind == "loop"]
    shape = estimator.shape(kernel.regions[loop])
    for below, ii, lost in ((least / 2, shape.ii, True), (2 * least, shape.ii, False)):
        race = Race(estimator, function, hints, below)
        assert race.is_lost(kernel, {loop: (ii, shape.span)}) is lost
    assert Race(estimator, function, hints, 2 * least).is_lost(kernel, {loop: (99, shape.span)})
    assert not Race(estimator, function, hints, math.inf).is_lost(kernel, {loop: (99, 99)})


def test_an_estimate_tells_what_it_allows_for_routing() -> None:
    """Whether a stage before could be better is asked without the allowance."""
    loop = RegionCost("b1", "loop", Shape(2, 26, 4), 3.0, 16.0)
    straight = RegionCost("b0", "straight", Shape(9, 9, 4), 1.0, 1.0)
    assert Estimate(200, (loop, straight)).least == 200 - 3 * 6


@pytest.mark.parametrize(("ii", "largest"), [(3, 40), (4, 0)])
def test_a_loop_with_half_of_its_slots_empty_is_not_large(ii: int, largest: int) -> None:
    loop = RegionCost("b1", "loop", Shape(ii, 26, 40), 3.0, 16.0)
    straight = RegionCost("b0", "straight", Shape(9, 9, 90), 1.0, 1.0)
    assert Estimate(200, (loop, straight)).largest_loop(16) == largest


@pytest.fixture
def slow_mapper(monkeypatch: pytest.MonkeyPatch) -> str:
    """A mapper that finds nothing for graphs larger than those of `nested` as written, takes all
    its time over that, and for others insists on a third of a compilation's 4 s.
    """
    loops = plan(nested, auto=False).stages[0].estimate.regions
    largest = max(loop.shape.operations for loop in loops if loop.kind == "loop")
    known: dict[DFG, MapResult] = {}

    def run(problem: MapProblem, request: MapRequest) -> MapResult:
        least_s = 4.0 * EFFORT_SHARE / 3
        if len(problem.dfg.operations) > largest or request.deadline.remaining_s < least_s:
            request.deadline.charge(request.deadline.remaining_s)
            return MapResult("timeout", None, 1, (), None, "slow", 0.0)
        graph = replace(problem.dfg, name="")
        if graph not in known:
            known[graph] = auto(problem, replace(request, deadline=Deadline.after(30.0)))
        return known[graph]

    monkeypatch.setitem(BUILT_IN, "slow", run)
    return "slow"


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1])")
def nested(a, b, y):
    """Interleaved or flattened if that maps in time."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j] * b[j, i]
        y[i] = total


def test_time_out_of_transformed_stages_leaves_enough_for_the_kernel_as_written(
    slow_mapper: str,
) -> None:
    assert len(plan(nested, restructure=False).stages) > 1
    arrays = [np.ones((24, 24), np.float32), np.ones((24, 24), np.float32), np.zeros(24, "f4")]
    written = vividc.compile(
        nested, MACHINE, slow_mapper, 4.0, loops=vividc.LoopOptions(auto=False)
    )
    loops = vividc.LoopOptions(restructure=False)
    program = vividc.compile(nested, MACHINE, slow_mapper, 4.0, loops=loops)
    assert program.warnings == written.warnings == ()
    assert [r.ii for r in program.regions] == [r.ii for r in written.regions]
    cycles = vividc.simulate(program, *arrays).cycles
    assert cycles <= vividc.simulate(written, *arrays).cycles
    assert (arrays[2] == 24).all()


@pytest.mark.parametrize("limit_s", [1.0, 20.0, 60.0, 600.0])
@pytest.mark.parametrize("stages", [1, 2, 5, 20])
def test_the_kernel_as_written_has_its_share_whatever_the_stages_before_it_took(
    limit_s: float, stages: int
) -> None:
    budget = Budget.of(Deadline.after(limit_s))
    for _ in range(stages):
        try:
            spent_s = budget.share(as_written=False).remaining_s
            budget.whole.charge(spent_s)
        except TimeLimit:
            break
    assert budget.share(as_written=True).remaining_s >= 0.4 * limit_s - 1e-6
    assert budget.share(as_written=True).at == pytest.approx(limit_s)


def test_a_transformed_stage_has_half_of_what_is_left_and_never_more_than_25_s() -> None:
    assert Budget.of(Deadline.after(20.0)).share(as_written=False).remaining_s == pytest.approx(
        10.0
    )
    assert Budget.of(Deadline.after(600.0)).share(as_written=False).remaining_s == pytest.approx(
        25.0
    )


def test_stages_that_come_too_late_are_not_tried() -> None:
    budget = Budget.of(Deadline.after(20.0))
    budget.whole.charge(12.5)
    with pytest.raises(TimeLimit, match="no time was left"):
        budget.share(as_written=False)


@pytest.mark.parametrize(
    ("achieved", "estimate", "tried"),
    [(90, 104, True), (90, 105, False), (200, 209, True), (200, 210, False)],
)
def test_in_haste_a_stage_is_left_out_that_is_expected_to_take_longer(
    achieved: float, estimate: float, tried: bool
) -> None:
    """Than the better one was expected to take, or took."""
    stalled = RegionCost("b1", "loop", Shape(1, 10, 4, stalls=1.0), 1.0, 50.0)
    loops = (stalled,)
    first = made(100).stages[0].state
    stages = Plan(tuple(Stage(first, Estimate(item, loops)) for item in (estimate, 100)))
    asked: list[float] = []

    def attempt(stage: Stage, *_: object) -> Outcome:
        asked.append(stage.estimate.cycles)
        return fake(stage, achieved)

    assert settle(stages, attempt, 1.05).index == 1
    assert asked == ([100, estimate] if tried else [100])


def test_in_haste_what_is_written_is_tried_if_the_hottest_loop_has_no_mapping() -> None:
    outcomes = [hot(500, by_block=False), hot(90, by_block=True)]
    stages = Plan(tuple(outcome.stage for outcome in outcomes))
    assert settle(stages, lambda *_: outcomes.pop(), 1.05).index == 0
