"""The clock of limits, and what stages do when time is up."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import vividc
from tests import kept
from vividc import arch
from vividc.errors import SourceLoc, TimeLimit
from vividc.host import time_limit


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Time that passes only when told."""
    now = SimpleNamespace(seconds=100.0)
    monkeypatch.setattr(time_limit, "time", SimpleNamespace(monotonic=lambda: now.seconds))
    return now


def test_without_a_limit_no_step_ends() -> None:
    time_limit.step("it ran")
    assert time_limit.remaining_s() == math.inf


def test_a_step_after_the_end_is_a_message_with_place_and_way_out(clock: SimpleNamespace) -> None:
    with time_limit.limited(5.0, "dot", SourceLoc("dot.py", 7)):
        clock.seconds += 4.9
        time_limit.step("its loops were mapped")
        clock.seconds += 0.2
        with pytest.raises(TimeLimit) as caught:
            time_limit.step("its loops were mapped")
    assert "dot.py:7: dot was not compiled within 5 s" in str(caught.value)
    assert "its loops were mapped" in str(caught.value)
    assert "--time-limit" in str(caught.value)
    assert caught.value.exit_code == 4


def test_a_limit_inside_ends_no_later_than_the_one_around_it(clock: SimpleNamespace) -> None:
    with time_limit.limited(5.0), time_limit.limited(10.0, grace_s=math.inf):
        assert time_limit.remaining_s() == pytest.approx(5.0)
        clock.seconds += 6.0
        with pytest.raises(TimeLimit, match="within 5 s"):
            time_limit.step("it ran")


def test_in_the_time_of_grace_nothing_is_left_and_steps_go_on(clock: SimpleNamespace) -> None:
    with time_limit.limited(5.0, grace_s=1.0):
        clock.seconds += 5.5
        assert time_limit.remaining_s() == 0.0
        time_limit.step("it ran")


def test_what_was_left_out_is_noted_once_by_the_outermost_limit(clock: SimpleNamespace) -> None:
    with time_limit.limited(5.0) as limit:
        with time_limit.limited(1.0):
            time_limit.left_out("a search")
        time_limit.left_out("a search")
    assert limit.cut == ["a search"]


def test_each_thread_has_its_own_limit() -> None:
    found: list[float] = []
    with time_limit.limited(5.0):
        thread = threading.Thread(target=lambda: found.append(time_limit.remaining_s()))
        thread.start()
        thread.join()
    assert found == [math.inf]


def in_python(x, n):  # type: ignore[no-untyped-def]
    total = np.int32(0)
    for i in range(n):
        for j in range(n):
            total += x[i] * x[j] + i
    return np.int32(total)


def kernel() -> vividc.KernelFunction:
    """A kernel that was not typed and lowered yet."""
    return vividc.kernel("int32(int32[::1], int32)")(in_python)


nested = kernel()


def _ends_at(stage: str) -> Callable[[str], None]:
    """A clock by which time is up when a stage of this name is reached."""

    def step(doing: str) -> None:
        if stage in doing:
            raise TimeLimit(f"time was up while {doing}")

    return step


@pytest.mark.parametrize(
    "stage",
    [
        "numba typed",
        "lowered",
        "ranges of values",
        "control flow",
        "estimated",
        "optimised",
        "straight regions",
    ],
)
def test_a_stage_without_which_there_is_no_program_ends_with_a_message(
    stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stage that no longer asks for the time fails here."""
    monkeypatch.setattr(time_limit, "step", _ends_at(stage))
    with kept.modules_made_anew(), pytest.raises(TimeLimit, match=stage):
        vividc.compile(kernel())


def test_the_choice_of_transformations_may_end_early_and_the_program_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chosen = "loop transformations were chosen"
    calls: list[str] = []

    def step(doing: str) -> None:
        if doing == chosen and not calls:
            calls.append(doing)
            raise TimeLimit("the share of the choice is used up")

    monkeypatch.setattr(time_limit, "step", step)
    with pytest.warns(vividc.VividcWarning, match="choice of loop transformations took too long"):
        program = vividc.compile(nested)
    assert any("took too long" in text for text in program.warnings)
    x = np.arange(5, dtype=np.int32)
    assert vividc.simulate(program, x, 5).value == nested(x, 5)


def test_without_time_loops_run_block_by_block_and_the_program_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(time_limit, "remaining_s", lambda: 0.0)
    monkeypatch.setattr("vividc.compiler.regions.map_regions.LEAST_S", 0.0)
    with pytest.warns(vividc.VividcWarning, match="runs block by block"):
        program = vividc.compile(nested, loops=vividc.LoopOptions(auto=False))
    assert {region.kind for region in program.regions} == {"straight"}
    assert any("the loop took too long" in text for text in program.warnings)
    x = np.arange(5, dtype=np.int32)
    assert vividc.simulate(program, x, 5).value == nested(x, 5)


def test_a_kernel_too_long_for_its_fabric_is_refused_before_anything_is_mapped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    machine = arch.load_accelerator("vivid")
    few = replace(machine.fabric.controller, contexts=2)
    short = replace(machine, tiles=tuple(replace(tile, controller=few) for tile in machine.tiles))
    monkeypatch.setattr("vividc.compiler.stage.map_kernel", None)
    with pytest.raises(vividc.VividcError, match=r"needs at least \d+ contexts") as caught:
        vividc.compile(nested, short, loops=vividc.LoopOptions(auto=False))
    assert caught.value.exit_code == 2
