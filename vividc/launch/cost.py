"""The work of a job on an accelerator, for its energy."""

from __future__ import annotations

from vividc.launch.accounting import JobStats
from vividc.program import WORD_BYTES
from vividc.sim.cost.energy import Work
from vividc.sim.engine import Activity


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
