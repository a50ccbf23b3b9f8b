"""Kernels on one tile: what each maps to, how well that is proved, how many cycles were predicted,
and how fast it is simulated.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from statistics import geometric_mean, median
from typing import Final

import vividc
from benchmarks import EFFORT, c_kernels, general, render_kernels
from benchmarks.workloads import WORKLOADS, Workload, transformations
from vividc.compiler.planning.estimate import RegionCost, Shape
from vividc.dfg.regions import loop_behind, runs_into
from vividc.program import Program
from vividc.sim import Stats

TABLES: Final[dict[str, tuple[str, tuple[Workload, ...]]]] = {
    "kernels": ("Kernels on one tile", (*WORKLOADS, *general.WORKLOADS)),
    "render": ("Stages of the renderers on one tile", render_kernels.WORKLOADS),
    "c_kernels": ("C kernels on one tile", c_kernels.WORKLOADS),
}
HEADER: Final = (
    "| kernel | hot loop ops | ResMII | RecMII | II | status | utilisation | all regions (cycles) "
    "| compile s | simulated cycles | predicted | as written | gain | transformations "
    "| simulated cycles/s |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
NOTES: Final = """\
- hot loop: the last innermost loop, or of transformed ones the one with most operations.
- predicted: the estimate's formula, with IIs, spans and expected bank stalls as mapped and the
  trips of the run, over the simulated cycles.
- compile s: seconds of processor time; simulated cycles/s: of the reference engine, likewise.
- as written: cycles without transformations of loops; gain: over the simulated ones.
""".splitlines()

_NEAR: Final = 0.15
"""Of the simulated cycles: predictions are to be so near."""


@dataclass(frozen=True, slots=True)
class Measured:
    """One line of a table, and of it what is summed up below.

    Attributes
    ----------
    compile_s
        Seconds of processor time.
    predicted
        Cycles by the estimate's formula over simulated ones.
    gain
        Cycles of the kernel as written over those with transformations.
    """

    text: str
    compile_s: float
    predicted: float
    gain: float


def lines(table: str, fabric: str, time_limit_s: float) -> Iterator[str]:
    """A table on one fabric, its header first, and what it comes to."""
    yield from HEADER.splitlines()
    made = []
    for workload in TABLES[table][1]:
        made.append(measured(workload, fabric, time_limit_s))
        yield made[-1].text
    yield ""
    yield from _summary(made)


def measured(workload: Workload, fabric: str, time_limit_s: float) -> Measured:
    """A kernel compiled and run, with and without transformations of loops."""
    plain = vividc.compile(
        workload.kernel(),
        fabric=fabric,
        time_limit_s=time_limit_s,
        loops=vividc.LoopOptions(auto=False),
        effort=EFFORT,
    )
    written = vividc.simulate(plain, *workload.fresh()).cycles
    start = time.process_time()
    program = vividc.compile(
        workload.kernel(), fabric=fabric, time_limit_s=time_limit_s, effort=EFFORT
    )
    compile_s = time.process_time() - start
    start = time.process_time()
    result = vividc.simulate(program, *workload.fresh(), engine="reference")
    simulate_s = time.process_time() - start
    share = predicted(program, result.stats) / result.cycles
    cells = [
        workload.name,
        *_hot(program),
        "+".join(str(region.ii) for region in program.regions),
        f"{compile_s:.1f}",
        f"{result.cycles:,}",
        f"{share:.2f}",
        f"{written:,}",
        f"{written / result.cycles:.2f}",
        transformations(program) or "-",
        f"{result.cycles / simulate_s:,.0f}",
    ]
    return Measured(f"| {' | '.join(cells)} |", compile_s, share, written / result.cycles)


def predicted(program: Program, stats: Stats) -> float:
    """The estimate's cycles of a run, by what each region takes and how often it ran."""
    total = float(stats["switch_cycles"])
    rows = zip(program.table, program.regions, stats["regions"], strict=True)
    for index, (row, report, region) in enumerate(rows):
        if row.drain:  # the region behind begins early whenever the loop had an iteration
            total -= row.drain * min(region["entries"], region["iterations"])
        total -= row.fill * _begun_early(program, stats, index)
        runs = region["entries"]
        trips = region["iterations"] / runs if runs and row.kind == "loop" else 1.0
        span = row.span if row.kind == "loop" else row.ii
        shape = Shape(row.ii, span, report.operations, stalls=report.stalls)
        total += RegionCost(report.name, row.kind, shape, runs, trips).cycles
    return total


def _begun_early(program: Program, stats: Stats, index: int) -> float:
    """How often a loop begins while a straight region ends: if it has enough iterations."""
    loop = loop_behind(program.table, index)
    fill, regions = program.table[index].fill, stats["regions"]
    if not fill or loop is None:
        return 0.0
    behind = regions[loop]
    if behind["iterations"] < program.table[loop].least_trips(fill) * behind["entries"]:
        return 0.0
    runs = [float(region["entries"]) for region in regions]
    return runs_into(program.table, index, loop, runs)


def _hot(program: Program) -> Iterable[str]:
    """Cells of the hot loop."""
    loops = [region for region in program.regions if region.kind == "loop"]
    is_changed = bool(transformations(program)) and bool(loops)
    loop = max(loops, key=lambda region: region.operations) if is_changed else None
    loop = loop or (loops or program.regions)[-1]
    bounds = {bound.name: bound.ii for bound in loop.bounds}
    res = max(ii for name, ii in bounds.items() if name != "RecMII")
    status = f"{loop.status}, by the clock" if program.hurried else loop.status
    numbers = loop.operations, res, bounds.get("RecMII", 1), loop.ii
    return [*(str(number) for number in numbers), status, f"{loop.utilization:.0%}"]


def _summary(made: list[Measured]) -> Iterator[str]:
    """What all rows of a table come to."""
    seconds = [row.compile_s for row in made]
    shares = [row.predicted for row in made]
    away = sum(abs(share - 1) > _NEAR for share in shares)
    gain = geometric_mean(row.gain for row in made)
    yield f"- compile s: median {median(seconds):.2f}, all together {sum(seconds):.0f}"
    yield (
        f"- predicted: {min(shares):.2f} to {max(shares):.2f}, "
        f"more than {_NEAR:.0%} away from the simulated cycles: {away} of {len(made)}"
    )
    yield f"- gain: geometric mean {gain:.2f}"
