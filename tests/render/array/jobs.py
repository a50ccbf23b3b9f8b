"""Statistics of jobs as they might have been."""

from __future__ import annotations

from vividc.launch import JobStats


def job_stats(
    cycles: int, *, tiles: int, dram: int = 0, noc: int = 0, idle: int = 0, **stalls: int
) -> JobStats:
    """Return the statistics of a job; `idle` and stalls are sums over its tiles."""
    waits = {name: stalls.get(name, 0) for name in ("dma", "configuration", "dependency", "bank")}
    spent = tiles * cycles - idle - sum(waits.values())
    uses = {"steady": spent, "idle": idle} if tiles else {}
    return JobStats(
        cycles=cycles,
        engine="native",
        steps={},
        runs=tiles,
        tile_cycles=spent,
        cycles_by_use=uses,
        stalls=waits if tiles else {},
        operations={},
        operations_by_class={},
        bytes={},
        busy={"dram": dram, "noc": noc},
        utilization=0.0,
        tiles=[
            {"tile": n, "runs": 1, "cycles": {}, "stalls": {}, "issued": 0, "utilization": 0.0}
            for n in range(tiles)
        ],
    )
