"""What an accelerator does for a job, step by step (docs/accelerator.md)."""

from vividc.sim.accelerator import (
    At,
    Event,
    Job,
    JobResult,
    JobStats,
    Spread,
    SpreadOptions,
    TileStats,
    spread,
)

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
