"""Simulation of a program on one tile: engines run its words and count cycles.

In order: `bind` (arguments into memory), `placed` (arrays that are there already), `engine` (what
an engine is), `reference/` and `native/`, `auto` (which of them runs), `accounting` and `stats`
(counts), `run`, `tile` (bound once, run often); `footprint/` (bytes of a loop), `cost/` (energy and
area), `view/` (traces and pictures).
"""

from vividc.sim.engine import Activity, Engine, EngineFactory, Launch, Progress, RegionRun, Run
from vividc.sim.native import NativeEngine
from vividc.sim.reference.engine import ReferenceEngine
from vividc.sim.run import CYCLE_LIMIT, Result
from vividc.sim.stats import RegionStats, Stats, statistics
from vividc.sim.tile import AUTO, ENGINES, Tile, TileResult

__all__ = [
    "AUTO",
    "CYCLE_LIMIT",
    "ENGINES",
    "Activity",
    "Engine",
    "EngineFactory",
    "Launch",
    "NativeEngine",
    "Progress",
    "ReferenceEngine",
    "RegionRun",
    "RegionStats",
    "Result",
    "Run",
    "Stats",
    "Tile",
    "TileResult",
    "statistics",
]
