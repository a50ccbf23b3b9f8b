"""Where the cycles of a job went, tile by tile, and the bytes at each level, as plain data."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import TypedDict

from vividc.launch.functional import Outcome
from vividc.launch.steps import Execute, Step, kind_of
from vividc.launch.timing import Timing
from vividc.program import Program
from vividc.sim.accounting import Work, by_kind, bytes_by_level, summed, work_of
from vividc.sim.engine import Activity, Run


class TileStats(TypedDict):
    """One tile. `cycles` (by what the tile did) and `stalls` (by cause) add up to the job's cycles.

    `cycles`: "steady": loops at their II; "prologue_epilogue": of loops; "straight": straight
    regions; "switch": between regions; "idle": after the tile's last run. `stalls`: "bank":
    accesses that met in a bank; "scratchpad": DMA had the banks; "dma": waits for transfers;
    "configuration": waits for a program; "dependency": waits for other tiles; "launch": the
    controller wrote launch words.
    """

    tile: int
    runs: int
    cycles: dict[str, int]
    stalls: dict[str, int]
    issued: int
    utilization: float


class JobStats(TypedDict):
    """A whole job. `tiles`: those that ran something. `cycles`, `stalls` and `operations` are sums
    over them, `operations_by_class` the last of these by latency class and precision; `bytes`: at
    each level; `busy`: cycles that DRAM and NoC were busy.
    """

    cycles: int
    engine: str
    steps: dict[str, int]
    runs: int
    tile_cycles: int
    cycles_by_use: dict[str, int]
    stalls: dict[str, int]
    operations: dict[str, int]
    operations_by_class: dict[str, dict[str, int]]
    bytes: dict[str, int]
    busy: dict[str, int]
    utilization: float
    tiles: list[TileStats]


_USES = ("steady", "prologue_epilogue", "straight", "switch")


def job_stats(steps: Sequence[Step], outcome: Outcome, timing: Timing) -> JobStats:
    """Collect the statistics of a job."""
    runs: dict[int, dict[int, _Runs]] = {}
    kinds: Counter[str] = Counter()
    for number, step in enumerate(steps):
        kinds[kind_of(step)] += 1
        if isinstance(step, Execute):
            of_tile = runs.setdefault(step.tile, {})
            of_tile.setdefault(id(step.program), _Runs(step.program)).add(outcome.runs[number])
    tiles, operations, moved = [], Counter[str](), list[Activity]()
    for tile in sorted(runs):
        works = [some.work() for some in runs[tile].values()]
        tiles.append(_tile_stats(tile, list(runs[tile].values()), works, timing))
        for work in works:
            operations.update(work.issued)
            moved.append(work.activity)
    pes = max((some.pes for of_tile in runs.values() for some in of_tile.values()), default=1)
    whole = pes * len(tiles) * timing.cycles
    activity = Activity.total(moved)
    engines = sorted({run.engine for run in outcome.runs.values()})
    return JobStats(
        cycles=timing.cycles,
        engine=", ".join(engines),
        steps=dict(sorted(kinds.items())),
        runs=len(outcome.runs),
        tile_cycles=sum(run.cycles for run in outcome.runs.values()),
        cycles_by_use=summed(tile["cycles"] for tile in tiles),
        stalls=summed(tile["stalls"] for tile in tiles),
        operations=dict(sorted(operations.items())),
        operations_by_class=by_kind(operations),
        bytes={**asdict(timing.moved), **bytes_by_level(activity)},
        busy=dict(timing.busy),
        utilization=operations.total() / whole if whole else 0.0,
        tiles=tiles,
    )


def joined_stats(parts: Sequence[JobStats], pes: int) -> JobStats:
    """The statistics of jobs that ran one after the other, on tiles of so many PEs."""
    cycles = sum(part["cycles"] for part in parts)
    operations: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    for part in parts:
        operations.update(part["operations"])
        kinds.update(part["steps"])
    numbers = sorted({tile["tile"] for part in parts for tile in part["tiles"]})
    tiles = [_joined_tile(number, parts, pes) for number in numbers]
    whole = pes * len(tiles) * cycles
    engines = {name for part in parts for name in part["engine"].split(", ") if name}
    return JobStats(
        cycles=cycles,
        engine=", ".join(sorted(engines)),
        steps=dict(sorted(kinds.items())),
        runs=sum(part["runs"] for part in parts),
        tile_cycles=sum(part["tile_cycles"] for part in parts),
        cycles_by_use=summed(tile["cycles"] for tile in tiles),
        stalls=summed(tile["stalls"] for tile in tiles),
        operations=dict(sorted(operations.items())),
        operations_by_class=by_kind(operations),
        bytes=summed(part["bytes"] for part in parts),
        busy=summed(part["busy"] for part in parts),
        utilization=operations.total() / whole if whole else 0.0,
        tiles=tiles,
    )


def _joined_tile(number: int, parts: Sequence[JobStats], pes: int) -> TileStats:
    """A tile in jobs one after the other; it is idle in those that do not use it."""
    own = [next((t for t in part["tiles"] if t["tile"] == number), None) for part in parts]
    unused = sum(p["cycles"] for p, tile in zip(parts, own, strict=True) if tile is None)
    used = [tile for tile in own if tile is not None]
    cycles = summed(tile["cycles"] for tile in used)
    issued = sum(tile["issued"] for tile in used)
    slots = pes * sum(part["cycles"] for part in parts)
    return TileStats(
        tile=number,
        runs=sum(tile["runs"] for tile in used),
        cycles={**cycles, "idle": cycles["idle"] + unused},
        stalls=summed(tile["stalls"] for tile in used),
        issued=issued,
        utilization=issued / slots if slots else 0.0,
    )


@dataclass(frozen=True, slots=True)
class _Runs:
    """Those of a program on a tile."""

    program: Program
    runs: list[Run] = field(default_factory=list)

    @property
    def pes(self) -> int:
        """Of the tile."""
        return len(self.program.fabric.pes)

    def add(self, run: Run) -> None:
        """Take one more."""
        self.runs.append(run)

    def work(self) -> Work:
        """What all of them did."""
        return work_of(self.program.table, self.runs)


def _tile_stats(
    tile: int, programs: Sequence[_Runs], works: Sequence[Work], timing: Timing
) -> TileStats:
    state = timing.tiles[tile]
    runs = [run for some in programs for run in some.runs]
    cycles = dict.fromkeys((*_USES, "bank_stall", "idle"), 0)
    cycles |= summed(work.cycles for work in works)
    cycles["switch"] = sum(run.switch_cycles for run in runs)
    issued = sum(sum(work.issued.values()) for work in works)
    stalls = {"bank": cycles.pop("bank_stall"), **state.stalls}
    cycles["idle"] = timing.cycles - state.free_from
    slots = programs[0].pes * timing.cycles
    return TileStats(
        tile=tile,
        runs=len(runs),
        cycles=cycles,
        stalls=stalls,
        issued=issued,
        utilization=issued / slots if slots else 0.0,
    )
