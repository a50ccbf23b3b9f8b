"""The roofline of a job: all tiles against DRAM."""

from __future__ import annotations

from vividc.arch import Accelerator
from vividc.host.plot import Picture
from vividc.launch.accounting import JobStats
from vividc.machine.opcodes import MEMORY
from vividc.sim.view.roofline import Point, Roof, roofline


def job_roofline(accelerator: Accelerator, stats: JobStats, name: str) -> Picture:
    """The job's operations over the bytes that DRAM moved, under the PEs of all tiles."""
    memory = {op.value for op in MEMORY}
    operations = sum(n for op, n in stats["operations"].items() if op not in memory)
    dram = stats["bytes"]["dram_read"] + stats["bytes"]["dram_written"]
    point = Point(name, operations, dram, stats["cycles"])
    peak = sum(len(tile.pes) for tile in accelerator.tiles)
    roof = Roof("DRAM", accelerator.dram.bytes_per_cycle)
    return roofline([point], peak, [roof], f"{name} on {accelerator.name}: roofline")
