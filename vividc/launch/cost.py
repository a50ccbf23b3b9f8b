"""What a job costs its accelerator: the work from which its energy is computed, and its
roofline.
"""

from __future__ import annotations

from vividc.arch import Accelerator
from vividc.host.plot import Picture
from vividc.launch.accounting import JobStats
from vividc.machine.opcodes import MEMORY
from vividc.program import WORD_BYTES
from vividc.sim.cost.energy import Work
from vividc.sim.engine import Activity
from vividc.sim.view.roofline import Point, Roof, roofline


def work_of_job(stats: JobStats, tiles: int) -> Work:
    """What all tiles did, and what DMA moved in and out of scratchpads and DRAM.

    Parameters
    ----------
    tiles
        Tiles of the accelerator: those that run nothing are on, too.
    """
    moved = stats["bytes"]

    def words(*levels: str) -> int:
        return sum(-(-moved[level] // WORD_BYTES) for level in levels)

    activity = Activity(
        link_words=words("links"),
        register_reads=words("registers_read"),
        register_writes=words("registers_written"),
        constant_reads=words("constants_read"),
        constant_writes=words("constants_written"),
        scratchpad_reads=words("scratchpad_read", "scratchpad_out"),
        scratchpad_writes=words("scratchpad_written", "scratchpad_in"),
    )
    dram = moved["dram_read"] + moved["dram_written"]
    return Work(stats["cycles"], stats["operations"], activity, tiles, dram)


def job_roofline(accelerator: Accelerator, stats: JobStats, name: str) -> Picture:
    """The job's operations over the bytes that DRAM moved, under the PEs of all tiles."""
    memory = {op.value for op in MEMORY}
    operations = sum(n for op, n in stats["operations"].items() if op not in memory)
    dram = stats["bytes"]["dram_read"] + stats["bytes"]["dram_written"]
    point = Point(name, operations, dram, stats["cycles"])
    peak = sum(len(tile.pes) for tile in accelerator.tiles)
    roof = Roof("DRAM", accelerator.dram.bytes_per_cycle)
    return roofline([point], peak, [roof], f"{name} on {accelerator.name}: roofline")
