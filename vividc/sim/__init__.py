"""Simulation of compiled programs: engines execute the configuration words and count cycles."""

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
