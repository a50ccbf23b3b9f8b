"""Launch graphs over the tiles of an accelerator, carried out exactly and timed by events.

In order: `images` (programs as tiles take them), `steps` and `job` (a graph of moves and runs,
built by hand), `turns` (places that chunks take in turn), `memory`, `own_arrays`, `flat` (the graph
as arrays), `hazards/` (is its order enough), `functional` (what it computes), `timing/` (when;
docs/accelerator.md), `accounting`, `simulate` (all of these, and the result); `tiles/` (a kernel's
loops on all tiles); `cost` (energy and roofline).
"""

from vividc.launch.accounting import JobStats, TileStats
from vividc.launch.job import Job
from vividc.launch.simulate import JobResult, joined
from vividc.launch.steps import Listed
from vividc.launch.tiles.nests import nests_cycles, nests_job, runs_of
from vividc.launch.tiles.spread import Spread, SpreadOptions, spread
from vividc.launch.timing.record import Event
from vividc.sim.placed import At

__all__ = [
    "At",
    "Event",
    "Job",
    "JobResult",
    "JobStats",
    "Listed",
    "Spread",
    "SpreadOptions",
    "TileStats",
    "joined",
    "nests_cycles",
    "nests_job",
    "runs_of",
    "spread",
]
