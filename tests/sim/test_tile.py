"""A program bound once and launched often; which engine runs it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.program.hand_kernels import dot, fabric, saxpy
from tests.sim.native.agreement import launch, outcome, same
from vividc import simulate
from vividc.errors import ArgumentError, CycleLimit, SimulationError
from vividc.program import Program
from vividc.sim import Launch, ReferenceEngine, Tile, auto
from vividc.sim.auto import AutoEngine


@pytest.fixture(autouse=True)
def engine() -> None:
    """Instead of the simulator's tests' fixture of this name: these tests name their engines."""


def sum_of(n: int) -> tuple[Program, Launch]:
    program = dot(fabric(latencies="{fma: 4}"))
    ones = np.ones(n, np.float32)
    return program, launch(program, ones, ones.copy(), n)


@pytest.mark.parametrize("name", ["auto", "native", "reference"])
def test_launches_do_not_disturb_each_other(name: str) -> None:
    program = saxpy(fabric())
    tile = Tile(program, name)
    for n in (8, 3, 8):
        given = launch(program, np.ones(n, np.float32), np.ones(n, np.float32), n)
        same(outcome(ReferenceEngine(program), given), outcome(tile, given))


def test_unknown_engine() -> None:
    with pytest.raises(ArgumentError, match="unknown engine 'fast'") as caught:
        Tile(saxpy(fabric()), "fast")
    assert caught.value.hint == "engines: auto, native, reference"


def test_short_runs_need_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "NativeEngine", None)
    program, given = sum_of(20)
    assert AutoEngine(program).run(given).engine == "reference"


def test_long_runs_are_native(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "TRIAL_CYCLES", 50)
    program, given = sum_of(20)
    engine = AutoEngine(program)
    told: list[int] = []
    run = engine.run(replace(given, progress=told.append))
    assert run.engine == "native"
    assert run.cycles == ReferenceEngine(program).run(given).cycles == told[-1]


def test_many_short_runs_are_native_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "TRIAL_CYCLES", 250)
    program, given = sum_of(20)
    tile = Tile(program)
    engines = [tile.run(given).engine for _ in range(5)]
    assert engines == ["reference"] * 2 + ["native"] * 3


def test_the_callers_cycle_limit_is_an_error_on_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "NativeEngine", None)
    program, given = sum_of(20)
    with pytest.raises(CycleLimit, match="after 30 cycles"):
        AutoEngine(program).run(replace(given, cycle_limit=30))


def test_errors_on_trial_are_errors() -> None:
    program = saxpy(fabric())
    given = launch(program, np.ones(4, np.float32), np.ones(5, np.float32), 5)
    with pytest.raises(SimulationError, match="out-of-bounds"):
        AutoEngine(program).run(given)


def test_stats_tell_the_engine() -> None:
    program = saxpy(fabric())
    x, y = np.ones(4, np.float32), np.ones(4, np.float32)
    stats = {
        name: simulate(program, x, y, 4, engine=name).stats for name in ("native", "reference")
    }
    assert stats["native"].pop("engine") == "native"
    assert stats["reference"].pop("engine") == "reference"
    assert stats["native"] == stats["reference"]
