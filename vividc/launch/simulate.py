"""Runs a launch graph: checks, computes, times and accounts for it."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from vividc.arch import Accelerator
from vividc.host.html import table
from vividc.launch.accounting import JobStats, job_stats, joined_stats
from vividc.launch.functional import Outcome, carry_out
from vividc.launch.hazards import check_order, predecessors
from vividc.launch.memory import Buffers
from vividc.launch.steps import Execute, Step
from vividc.launch.timing import schedule
from vividc.launch.timing.record import Event, Record, joined_record
from vividc.sim.bind import returned


@dataclass(frozen=True, slots=True)
class JobResult:
    """The outcome of a job.

    Attributes
    ----------
    cycles
        From the first cycle to the end of the last step.
    value
        What a kernel returns, as of `sim.Result`; None for a graph made by hand.
    values
        What each run returned, by step number; `words`: the same as words.
    stats
        Where the cycles of each tile went, and the bytes moved at each level.
    record
        What `events` are made from.
    """

    cycles: int
    value: Any
    values: ReadOnly[int, int | float | bool | None]
    words: ReadOnly[int, int]
    stats: JobStats
    record: Record

    def __repr__(self) -> str:
        value = "" if self.value is None else f", value {self.value!r}"
        where = f"{self.stats['runs']} runs on {len(self.stats['tiles'])} tiles"
        return f"<JobResult: {self.cycles} cycles{value}, {where}>"

    def _repr_html_(self) -> str:
        tiles = self.stats["tiles"]
        causes = list(dict.fromkeys(cause for tile in tiles for cause in tile["stalls"]))
        rows = (
            (
                *(number, sum(tile["cycles"].values()) - tile["cycles"].get("idle", 0)),
                *(tile["stalls"].get(cause, 0) for cause in causes),
            )
            for number, tile in enumerate(tiles)
        )
        header = ("tile", "busy", *(f"waits: {cause}" for cause in causes))
        return table(header, rows, repr(self)[1:-1])

    @property
    def events(self) -> tuple[Event, ...]:
        """What every unit did, by start; made anew each time."""
        return self.record.events()


def joined(parts: Sequence[JobResult]) -> JobResult:
    """The outcome of jobs, at least one, that ran one after the other on the same accelerator: each
    starts when the one before is done. Steps are numbered through.
    """
    starts = [0, *accumulate(len(part.record.steps) for part in parts)]
    numbered = list(zip(starts, parts, strict=False))
    steps = [step for part in parts for step in part.record.steps]
    pes = [len(step.program.fabric.pes) for step in steps if isinstance(step, Execute)]
    return JobResult(
        cycles=sum(part.cycles for part in parts),
        value=None,
        values={at + n: value for at, part in numbered for n, value in part.values.items()},
        words={at + n: word for at, part in numbered for n, word in part.words.items()},
        stats=joined_stats([part.stats for part in parts], max(pes, default=1)),
        record=joined_record([(part.record, part.cycles) for part in parts]),
    )


def simulate_steps(
    accelerator: Accelerator,
    steps: Sequence[Step],
    buffers: Buffers,
    engine: str,
    cycle_limit: int,
    threads: int | None,
) -> JobResult:
    """Carry a graph out (see `Job.simulate`)."""
    waits = predecessors(steps, accelerator.sharing)
    check_order(steps, waits, buffers)
    outcome = carry_out(accelerator, steps, waits, buffers, engine, cycle_limit, threads)
    timing = schedule(accelerator, steps, waits, outcome)
    return JobResult(
        cycles=timing.cycles,
        value=None,
        values=_values(steps, outcome),
        words={n: run.value for n, run in outcome.runs.items() if run.value is not None},
        stats=job_stats(steps, outcome, timing),
        record=timing.record,
    )


def _values(steps: Sequence[Step], outcome: Outcome) -> dict[int, int | float | bool | None]:
    values: dict[int, int | float | bool | None] = {}
    for number, run in outcome.runs.items():
        step = steps[number]
        assert isinstance(step, Execute)
        word, dtype = run.value, step.program.returns
        values[number] = None if word is None or dtype is None else returned(dtype, word)
    return values
