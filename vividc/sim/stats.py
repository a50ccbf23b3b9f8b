"""The statistics of a run as plain data, ready for JSON."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import TypedDict

from vividc.program import Program
from vividc.sim.engine import RegionRun, Run


class RegionStats(TypedDict):
    """One region, summed over its runs.

    `stalls`: cycles by cause. `utilization`: issues per FU and cycle.
    """

    name: str
    kind: str
    ii: int
    entries: int
    iterations: int
    cycles: int
    stalls: dict[str, int]
    operations: dict[str, int]
    utilization: float


class Stats(TypedDict):
    """A whole run.

    `cycles` = the regions' cycles + `switch_cycles`; `stalls` are part of the regions' cycles.
    `operations`: issues by opcode name. `activity`: the counts of `engine.Activity`. `engine`: the
    engine that ran it; it changes nothing else.
    """

    engine: str
    cycles: int
    switch_cycles: int
    stalls: dict[str, int]
    operations: dict[str, int]
    activity: dict[str, int]
    utilization: float
    regions: list[RegionStats]


def statistics(program: Program, run: Run) -> Stats:
    """Collect the statistics of `run`."""
    pes = len(program.fabric.pes)
    operations: Counter[str] = Counter()
    for region in run.regions:
        operations.update(region.issued)
    return Stats(
        engine=run.engine,
        cycles=run.cycles,
        switch_cycles=run.switch_cycles,
        stalls={"bank_conflict": sum(region.bank_stalls for region in run.regions)},
        operations=dict(sorted(operations.items())),
        activity=asdict(run.activity),
        utilization=_share(operations.total(), pes * run.cycles),
        regions=[
            _region_stats(program, index, region, pes) for index, region in enumerate(run.regions)
        ],
    )


def _region_stats(program: Program, index: int, region: RegionRun, pes: int) -> RegionStats:
    report = program.regions[index]
    return RegionStats(
        name=report.name,
        kind=report.kind,
        ii=report.ii,
        entries=region.entries,
        iterations=region.iterations,
        cycles=region.cycles,
        stalls={"bank_conflict": region.bank_stalls},
        operations=dict(region.issued),
        utilization=_share(sum(region.issued.values()), pes * region.cycles),
    )


def _share(part: int, whole: int) -> float:
    return part / whole if whole else 0.0
