"""Transfers cut into the bursts that DRAM and NoC see (docs/accelerator.md, Transfers)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vividc.arch import Accelerator
from vividc.launch.flat import Ints, Ints2
from vividc.launch.steps import Transfer
from vividc.launch.timing.compiled import compiled
from vividc.launch.timing.state import DRAM_BYTES, DRAM_CYCLES, NOC_CYCLES, OWNER, PAD_CYCLES, SIZE
from vividc.program import WORD_BYTES


class Cut(NamedTuple):
    """What the bursts of a machine depend on: their length and DRAM's granule, in bytes; bytes that
    channel and NoC move in a cycle.
    """

    length: int
    granule: int
    channel: int
    network: int


def cut_of(machine: Accelerator) -> Cut:
    """How an accelerator cuts transfers."""
    return Cut(
        machine.dma.burst_bytes,
        machine.dram.granule_bytes,
        machine.dram.bytes_per_cycle,
        machine.noc.bytes_per_cycle,
    )


def line_bytes(machine: Accelerator, step: Transfer) -> int:
    """What the scratchpads of a transfer take in one cycle: words that meet in no bank."""
    banks = min(machine.units[tile].scratchpad.banks for tile in step.tiles)
    return max(WORD_BYTES, WORD_BYTES * (WORD_BYTES * banks // step.pitch))


def cut_pieces(cut: Cut, owners: Ints, lines: Ints, pieces: Ints) -> tuple[Ints, Ints]:
    """Cut each piece at the multiples of the burst length.

    Parameters
    ----------
    owners
        By piece [n]: the step that moves it.
    lines
        By piece [n]: what a scratchpad takes in one cycle, in bytes.
    pieces
        [n, 2]: where in its array it starts, and its size, in bytes.

    Returns
    -------
    tuple[Ints, Ints]
        The first burst of each piece and behind the last [n + 1], and the bursts (`Graph.bursts`).
    """
    starts, sizes = pieces[:, 0], pieces[:, 1]
    counts = np.where(sizes > 0, (starts + sizes - 1) // cut.length - starts // cut.length + 1, 0)
    first = np.zeros(len(pieces) + 1, dtype=np.int64)
    np.cumsum(counts, out=first[1:])
    bursts = np.empty((first[-1], 6), dtype=np.int64)
    _cut(cut, owners, lines, pieces, bursts)
    return first, bursts


@compiled
def _cut(cut: Cut, owners: Ints, lines: Ints, pieces: Ints2, bursts: Ints2) -> None:
    place = 0
    for piece in range(len(pieces)):
        start = pieces[piece, 0]
        end = start + pieces[piece, 1]
        while start < end:
            stop = min(end, (start // cut.length + 1) * cut.length)
            moved = -(-stop // cut.granule) * cut.granule - start // cut.granule * cut.granule
            size = stop - start
            bursts[place, SIZE] = size
            bursts[place, DRAM_BYTES] = moved
            bursts[place, DRAM_CYCLES] = -(-moved // cut.channel)
            bursts[place, NOC_CYCLES] = -(-size // cut.network)
            bursts[place, PAD_CYCLES] = -(-size // lines[piece])
            bursts[place, OWNER] = owners[piece]
            place += 1
            start = stop
