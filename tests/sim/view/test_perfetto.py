"""Traces are Chrome trace events whose slices nest and add up."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from tests.sim.view.test_recording import X, strided_arguments
from vividc.sim.run import simulate
from vividc.sim.view import Timeline, job_trace, run_trace

PHASES = ("steady", "prologue, epilogue")


def check_schema(trace):
    """What the viewers need of each event (Trace Event Format)."""
    assert set(trace) == {"traceEvents", "displayTimeUnit", "otherData"}
    assert json.loads(json.dumps(trace, allow_nan=False)) == trace
    for event in trace["traceEvents"]:
        assert {"name", "ph", "pid", "tid", "args"} <= set(event)
        assert event["ph"] in ("X", "M", "C")
        assert isinstance(event["pid"], int)
        assert isinstance(event["tid"], int)
        if event["ph"] != "M":
            assert event["ts"] >= 0
        if event["ph"] == "X":
            assert event["dur"] >= 0


def traced(program, *arguments):
    line = Timeline()
    result = simulate(program, *arguments, observer=line.add)
    trace = run_trace(program, line.spans)
    check_schema(trace)
    slices = [event for event in trace["traceEvents"] if event["ph"] == "X"]
    return result, slices


def test_regions_cover_the_run(programs):
    result, slices = traced(programs["total"], X, 40)
    regions = [event for event in slices if event["name"] not in PHASES]
    names = {region["name"] for region in result.stats["regions"] if region["entries"]}
    assert {event["name"] for event in regions} == names
    cycles = sum(e["args"]["end_cycle"] - e["args"]["start_cycle"] for e in regions)
    assert cycles + result.stats["switch_cycles"] == result.cycles
    assert [e["ts"] for e in regions] == sorted(e["ts"] for e in regions)
    last = regions[-1]
    assert last["ts"] + last["dur"] == pytest.approx(result.cycles / 1000)


def test_phases_of_a_loop_are_those_of_the_statistics(programs):
    result, slices = traced(programs["total"], X, 40)
    for name, use in zip(PHASES, ("steady", "prologue_epilogue"), strict=True):
        cycles = sum(
            e["args"]["end_cycle"] - e["args"]["start_cycle"] for e in slices if e["name"] == name
        )
        assert cycles == result.stats["cycles_by_use"][use]


def test_stalls_are_told(programs):
    result, slices = traced(programs["strided"], *strided_arguments())
    told = sum(event["args"].get("bank_stalls", 0) for event in slices)
    assert told == result.stats["stalls"]["bank_conflict"] > 0


def test_a_timeline_says_what_it_dropped(programs):
    line = Timeline(most=2)
    simulate(programs["total"], X, 40, observer=line.add)
    assert len(line.spans) == 2
    assert line.dropped > 0
    trace = run_trace(programs["total"], line.spans, dropped=line.dropped)
    assert trace["otherData"] == {"dropped_regions": line.dropped}


@dataclass(frozen=True)
class Event:
    unit: str
    index: int
    kind: str
    step: int
    start: int
    end: int
    size_bytes: int = 0
    program: str = ""


def test_units_of_a_job_have_rows_of_their_own():
    events = [
        Event("tile", 1, "run", 3, 100, 150, program="saxpy"),
        Event("dma", 0, "move in", 0, 0, 60, 256),
        Event("tile", 0, "run", 2, 60, 90, program="saxpy"),
        Event("configuration", 0, "configure", 1, 0, 40, program="saxpy"),
    ]
    trace = job_trace(events, clock_ghz=0.5)
    check_schema(trace)
    slices = {e["args"]["step"]: e for e in trace["traceEvents"] if e["ph"] == "X"}
    assert {step: (e["ts"], e["dur"]) for step, e in slices.items()} == {
        0: (0, 0.12),
        1: (0, 0.08),
        2: (0.12, 0.06),
        3: (0.2, 0.1),
    }
    assert len({(e["pid"], e["tid"]) for e in slices.values()}) == 4
    assert slices[2]["pid"] == slices[3]["pid"]
    assert slices[3]["name"] == "run saxpy"
    assert slices[0]["args"]["bytes"] == 256


def test_an_empty_loop_has_no_phases(programs):
    _, slices = traced(programs["total"], np.zeros(1, np.int32), 0)
    assert not [event for event in slices if event["name"] in PHASES]
