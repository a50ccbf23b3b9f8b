"""The native engine tells of regions' runs as the reference engine does, however it is stopped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vividc
from tests.sim.native.agreement import launch
from tests.sim.view import small_kernels
from vividc.errors import SimulationError
from vividc.program import Program
from vividc.sim import Engine, NativeEngine, ReferenceEngine
from vividc.sim.auto import AutoEngine
from vividc.sim.engine import RegionSpan
from vividc.sim.native import engine as native

X = np.arange(300, dtype=np.int32)


@pytest.fixture(scope="module")
def find() -> Program:
    return vividc.compile(small_kernels.find, time_limit_s=30)


@pytest.fixture(scope="module")
def total() -> Program:
    return vividc.compile(small_kernels.total, time_limit_s=30)


def spans_of(engine: Engine, program: Program, *arguments: object) -> list[RegionSpan]:
    found: list[RegionSpan] = []
    engine.run(replace(launch(program, *arguments), observer=found.append))
    return found


@pytest.mark.parametrize("budget", [1, 7, 4_000_000])
def test_a_suspended_loop_is_one_run(
    total: Program, budget: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(native, "CYCLES_A_CALL", budget)
    expected = spans_of(ReferenceEngine(total), total, X, 300)
    assert spans_of(NativeEngine(total), total, X, 300) == expected


def test_the_auto_engine_tells_of_each_run_once(total: Program) -> None:
    many = np.zeros(7000, np.int32)
    expected = spans_of(ReferenceEngine(total), total, many, 7000)
    assert spans_of(AutoEngine(total), total, many, 7000) == expected


def test_regions_before_a_fault_are_told_of_once(find: Program) -> None:
    found = []
    for engine in (ReferenceEngine(find), NativeEngine(find)):
        spans: list[RegionSpan] = []
        given = replace(launch(find, X, 999), observer=spans.append)
        with pytest.raises(SimulationError, match="out-of-bounds"):
            engine.run(given)
        found.append(spans)
    assert found[0] == found[1]


def test_an_observer_changes_nothing_else(find: Program) -> None:
    engine = NativeEngine(find)
    given = launch(find, X, 250)
    quiet = engine.run(given)
    told = engine.run(replace(given, observer=lambda span: None))
    np.testing.assert_array_equal(quiet.memory, told.memory)
    nothing = np.zeros(0, np.uint32)
    assert replace(quiet, memory=nothing).regions == replace(told, memory=nothing).regions
    assert (quiet.cycles, quiet.activity, quiet.value) == (told.cycles, told.activity, told.value)
