"""The statistics of a run as plain data, ready for JSON."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import TypedDict

from vividc.program import Program
from vividc.sim.accounting import USES, by_kind, bytes_by_level, cycles_by_use, summed
from vividc.sim.engine import RegionRun, Run


class RegionStats(TypedDict):
    """One region, summed over its runs.

    `stalls`: cycles by cause. `cycles_by_use`: all cycles (see `accounting.cycles_by_use`).
    `operations`: issues by opcode name; `operations_by_class`: by latency class and precision.
    `activity`: the counts of `engine.Activity`; `bytes`: the same in bytes, by level.
    `utilization`: issues per FU and cycle.
    """

    name: str
    kind: str
    ii: int
    entries: int
    iterations: int
    cycles: int
    stalls: dict[str, int]
    cycles_by_use: dict[str, int]
    operations: dict[str, int]
    operations_by_class: dict[str, dict[str, int]]
    activity: dict[str, int]
    bytes: dict[str, int]
    utilization: float


class Stats(TypedDict):
    """A whole run.

    `cycles` = the regions' cycles + `switch_cycles`; `stalls` are part of the regions' cycles, and
    `reload_cycles`, in which contexts of a long program were brought, of `switch_cycles`.
    `cycles_by_use`: the regions', and "switch": between them. The other counts are the regions'
    sums. `engine`: the engine that ran it; it changes nothing else.
    """

    engine: str
    cycles: int
    switch_cycles: int
    reload_cycles: int
    stalls: dict[str, int]
    cycles_by_use: dict[str, int]
    operations: dict[str, int]
    operations_by_class: dict[str, dict[str, int]]
    activity: dict[str, int]
    bytes: dict[str, int]
    utilization: float
    regions: list[RegionStats]


def statistics(program: Program, run: Run) -> Stats:
    """Collect the statistics of `run`."""
    pes = len(program.fabric.pes)
    operations: Counter[str] = Counter()
    for region in run.regions:
        operations.update(region.issued)
    regions = [
        _region_stats(program, index, region, pes) for index, region in enumerate(run.regions)
    ]
    uses = summed([dict.fromkeys(USES, 0), *(region["cycles_by_use"] for region in regions)])
    return Stats(
        engine=run.engine,
        cycles=run.cycles,
        switch_cycles=run.switch_cycles,
        reload_cycles=run.reload_cycles,
        stalls={"bank_conflict": sum(region.bank_stalls for region in run.regions)},
        cycles_by_use={**uses, "switch": run.switch_cycles},
        operations=dict(sorted(operations.items())),
        operations_by_class=by_kind(operations),
        activity=asdict(run.activity),
        bytes=bytes_by_level(run.activity),
        utilization=_share(operations.total(), pes * run.cycles),
        regions=regions,
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
        cycles_by_use=cycles_by_use(program.table[index], region),
        operations=dict(region.issued),
        operations_by_class=by_kind(region.issued),
        activity=asdict(region.activity),
        bytes=bytes_by_level(region.activity),
        utilization=_share(sum(region.issued.values()), pes * region.cycles),
    )


def _share(part: int, whole: int) -> float:
    return part / whole if whole else 0.0
