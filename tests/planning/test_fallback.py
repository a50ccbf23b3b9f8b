"""Which stage of a plan is kept."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.planning.test_choose import MACHINE, plan, product
from vividc import driver
from vividc.errors import MappingFailed, TimeLimit
from vividc.planning.choose import Plan, Stage
from vividc.planning.estimate import Estimate
from vividc.planning.fallback import Outcome, settle


def fake(stage: Stage, cycles: float) -> Outcome:
    """An outcome of which only the cycles count."""
    return Outcome(stage, None, {}, None, Estimate(cycles, ()), {})  # type: ignore[arg-type]


def made(*cycles: float) -> Plan:
    """A plan whose stages are estimated so."""
    first = plan(product, mode="none").stages[0]
    return Plan(tuple(Stage(first.state, Estimate(item, ())) for item in cycles))


def test_the_last_stage_that_is_as_good_as_estimated_is_kept() -> None:
    stages = made(100, 50, 25)
    settled = settle(stages, lambda stage, _: fake(stage, stage.estimate.cycles + 5))
    assert settled.index == 2
    assert settled.dropped == {}


def test_a_stage_that_does_not_map_gives_way_to_the_one_before() -> None:
    stages = made(100, 50, 25)

    def attempt(stage: Stage, _: bool) -> Outcome:
        if stage is stages.stages[2]:
            raise TimeLimit("too slow")
        return fake(stage, stage.estimate.cycles)

    settled = settle(stages, attempt)
    assert settled.index == 1
    assert "too slow" in settled.dropped[2]


def test_a_stage_that_turns_out_slower_gives_way() -> None:
    stages = made(100, 50, 25)
    achieved = {id(stages.stages[2]): 80.0, id(stages.stages[1]): 50.0}
    settled = settle(stages, lambda stage, _: fake(stage, achieved.get(id(stage), 100.0)))
    assert settled.index == 1
    assert "slower" in settled.dropped[2]


def test_a_stage_before_that_is_not_better_after_all_is_not_taken() -> None:
    stages = made(100, 50)
    achieved = {id(stages.stages[1]): 110.0}
    settled = settle(stages, lambda stage, _: fake(stage, achieved.get(id(stage), 120.0)))
    assert settled.index == 1


def test_what_the_user_asks_for_need_not_pay() -> None:
    stages = replace(made(100, 200), asked=1)
    settled = settle(stages, lambda stage, _: fake(stage, stage.estimate.cycles))
    assert settled.index == 1


def test_the_kernel_as_written_is_the_last_resort() -> None:
    def attempt(stage: Stage, last_resort: bool) -> Outcome:
        raise MappingFailed("last" if last_resort else "transformed")

    with pytest.raises(MappingFailed, match="last"):
        settle(made(100, 50), attempt)


def test_a_transformed_loop_without_a_mapping_leaves_a_modulo_schedule(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The kernel as written still pipelines: it does not run block by block."""
    real = driver.map_kernel

    def fails_if_jammed(kernel, *rest):  # type: ignore[no-untyped-def]
        headers = [region.header for region in kernel.regions if region.kind == "loop"]
        if any("jam" in header for header in headers):
            error = TimeLimit("no time")
            error.header = next(header for header in headers if "jam" in header)
            raise error
        return real(kernel, *rest)

    monkeypatch.setattr(driver, "map_kernel", fails_if_jammed)
    program = driver.compile(product, MACHINE)
    assert [region.kind for region in program.regions].count("loop") == 1
    reasons = [item.reason for loop in program.loops for item in loop.transforms]
    assert any("no time" in reason for reason in reasons)
