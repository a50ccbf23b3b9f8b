"""The accelerator: launch graphs over sixteen tiles, carried out exactly and timed by events."""

from vividc.sim.accelerator.accounting import JobStats, TileStats
from vividc.sim.accelerator.event import Event
from vividc.sim.accelerator.job import At, Job
from vividc.sim.accelerator.result import JobResult
from vividc.sim.accelerator.spread import Spread, SpreadOptions, spread

__all__ = [
    "At",
    "Event",
    "Job",
    "JobResult",
    "JobStats",
    "Spread",
    "SpreadOptions",
    "TileStats",
    "spread",
]
