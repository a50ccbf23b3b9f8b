"""Runs and jobs as Chrome trace events, which Perfetto and chrome://tracing show.

Times of trace events are microseconds; a cycle at 1 GHz is a thousandth.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, Protocol

from vividc.program import Program
from vividc.sim.accounting import cycles_by_use
from vividc.sim.engine import RegionRun, RegionSpan

TraceEvent = dict[str, object]
_MOST_SPANS: Final = 200_000


class Timeline:
    """Keeps the runs of regions, up to a number of them; give its `add` to a launch as observer."""

    def __init__(self, most: int = _MOST_SPANS) -> None:
        self._most = most
        self._spans: list[RegionSpan] = []
        self.dropped = 0

    def add(self, span: RegionSpan) -> None:
        """Keep one."""
        if len(self._spans) < self._most:
            self._spans.append(span)
        else:
            self.dropped += 1

    @property
    def spans(self) -> tuple[RegionSpan, ...]:
        """Those kept, in order."""
        return tuple(self._spans)


class UnitEvent(Protocol):
    """What a unit of the accelerator did when (`launch.Event`)."""

    @property
    def unit(self) -> str:
        """ "tile", "dma" or "configuration"."""

    @property
    def index(self) -> int:
        """Number of the tile or engine."""

    @property
    def kind(self) -> str:
        """What was done."""

    @property
    def step(self) -> int:
        """Number of the step in the graph."""

    @property
    def start(self) -> int:
        """First cycle."""

    @property
    def end(self) -> int:
        """The cycle after the last."""

    @property
    def size_bytes(self) -> int:
        """Bytes moved."""

    @property
    def program(self) -> str:
        """Program run or configured."""


def run_trace(
    program: Program, spans: Sequence[RegionSpan], *, dropped: int = 0
) -> dict[str, object]:
    """The trace of a run on one tile: its regions, inside them what loops spent outside their
    steady state, and the stalls as a counter.

    A loop's slices "steady" and "prologue, epilogue" have these lengths; where stalls lie in a
    region is not known, so a run of a region with stalls has no such slices.

    Parameters
    ----------
    dropped
        Runs of regions that were not kept; the trace says so.
    """
    clock = program.fabric.clock_ghz
    events: list[TraceEvent] = [
        _name("process_name", 0, 0, f"{program.name} on {program.fabric_name}"),
        _name("thread_name", 0, 0, "regions"),
    ]
    for span in spans:
        report, row = program.regions[span.region], program.table[span.region]
        args = {
            "kind": report.kind,
            "ii": row.ii,
            "iterations": span.iterations,
            "bank_stalls": span.bank_stalls,
            "source": str(report.loc or ""),
        }
        events.append(_slice(report.name, 0, 0, (span.start, span.end), clock, args))
        events += _phases(program, span, clock)
        share = span.bank_stalls / (span.end - span.start) if span.end > span.start else 0.0
        events.append(_counter("bank stalls, share of cycles", span.start, clock, share))
    return _document(events, {"dropped_regions": dropped} if dropped else {})


def job_trace(
    events: Iterable[UnitEvent], *, name: str = "accelerator", clock_ghz: float = 1.0
) -> dict[str, object]:
    """The trace of a job: a row for each tile, DMA engine and the configuration stream."""
    traced: list[TraceEvent] = []
    rows: dict[tuple[str, int], tuple[int, int]] = {}
    units = {"tile": 0, "dma": 1, "configuration": 2}
    for event in sorted(events, key=lambda e: (units.get(e.unit, 3), e.index, e.start, e.step)):
        row = (units.get(event.unit, 3), event.index)
        if (event.unit, event.index) not in rows:
            rows[event.unit, event.index] = row
            traced.append(_name("process_name", row[0], row[1], f"{name}: {event.unit}"))
            traced.append(_name("thread_name", row[0], row[1], f"{event.unit} {event.index}"))
        args: dict[str, object] = {"step": event.step, "bytes": event.size_bytes}
        title = f"{event.kind} {event.program}".rstrip()
        times = (event.start, event.end)
        traced.append(_slice(title, row[0], row[1], times, clock_ghz, args))
    return _document(traced, {})


def _phases(program: Program, span: RegionSpan, clock: float) -> list[TraceEvent]:
    row = program.table[span.region]
    if row.kind != "loop" or span.bank_stalls or span.end <= span.start:
        return []
    run = RegionRun(1, span.iterations, span.end - span.start, 0, {})
    steady = span.start + cycles_by_use(row, run)["steady"]
    phases = (("steady", span.start, steady), ("prologue, epilogue", steady, span.end))
    return [
        _slice(name, 0, 0, (start, end), clock, {}) for name, start, end in phases if end > start
    ]


def _slice(
    name: str,
    process: int,
    thread: int,
    times: tuple[int, int],
    clock: float,
    args: Mapping[str, object],
) -> TraceEvent:
    start, end = times
    return {
        "name": name,
        "ph": "X",
        "pid": process,
        "tid": thread,
        "ts": _microseconds(start, clock),
        "dur": _microseconds(end - start, clock),
        "args": {**args, "start_cycle": start, "end_cycle": end},
    }


def _counter(name: str, cycle: int, clock: float, value: float) -> TraceEvent:
    ts = _microseconds(cycle, clock)
    return {"name": name, "ph": "C", "pid": 0, "tid": 0, "ts": ts, "args": {"share": value}}


def _name(what: str, process: int, thread: int, name: str) -> TraceEvent:
    return {"name": what, "ph": "M", "pid": process, "tid": thread, "args": {"name": name}}


def _microseconds(cycles: int, clock_ghz: float) -> float:
    return cycles / (1000 * clock_ghz)


def _document(events: list[TraceEvent], other: Mapping[str, object]) -> dict[str, object]:
    return {"traceEvents": events, "displayTimeUnit": "ns", "otherData": dict(other)}
