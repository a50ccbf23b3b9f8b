"""Transfers cut into the bursts that DRAM and NoC see (docs/accelerator.md, Transfers)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from vividc.arch import Accelerator
from vividc.sim.accelerator.steps import Piece


@dataclass(frozen=True, slots=True)
class Burst:
    """One access to DRAM and its trip over the NoC.

    Attributes
    ----------
    size
        Bytes that are wanted.
    dram_bytes
        Bytes that DRAM moves: whole granules.
    dram_cycles, noc_cycles, pad_cycles
        How long it holds the channel, the NoC, and the banks of a scratchpad.
    """

    size: int
    dram_bytes: int
    dram_cycles: int
    noc_cycles: int
    pad_cycles: int


def bursts(accelerator: Accelerator, pieces: Iterable[Piece], line_bytes: int) -> Iterator[Burst]:
    """The bursts of a transfer: each piece cut at the multiples of the burst length.

    Parameters
    ----------
    line_bytes
        What a scratchpad takes in one cycle: a word in each bank.
    """
    length, granule = accelerator.dma.burst_bytes, accelerator.dram.granule_bytes
    dram, noc = accelerator.dram.bytes_per_cycle, accelerator.noc.bytes_per_cycle
    for piece in pieces:
        start, end = piece.offset, piece.offset + piece.size
        while start < end:
            stop = min(end, (start // length + 1) * length)
            moved = -(-stop // granule) * granule - start // granule * granule
            size = stop - start
            pad = -(-size // line_bytes)
            yield Burst(size, moved, -(-moved // dram), max(-(-size // noc), pad), pad)
            start = stop
