"""A launch graph carried out: checked, computed, timed, counted."""

from __future__ import annotations

from collections.abc import Sequence

from vividc.arch import Accelerator
from vividc.launch.accounting import job_stats
from vividc.launch.functional import Outcome, carry_out
from vividc.launch.hazards import check_order, predecessors
from vividc.launch.memory import Buffers
from vividc.launch.result import JobResult
from vividc.launch.steps import Execute, Step
from vividc.launch.timing import schedule
from vividc.sim.bind import returned


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
    check_order(steps, waits)
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
