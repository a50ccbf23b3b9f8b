"""Rows of arrays chosen by indices: indexed DMA into scratchpads, and out again contiguously."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import Turns
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.arrays import Float32Array

_MOST_ROWS = 128


def gather_rows(
    device: Device,
    ledger: Ledger,
    stage: str,
    table: Float32Array,
    rows: Sequence[npt.NDArray[np.int32]],
) -> Float32Array:
    """Return `table[rows]` for the rows of all pieces, one after the other.

    Parameters
    ----------
    table
        [n, ...] float32; a row fits half a scratchpad.
    rows
        Pieces of indices, wherever they are in DRAM.
    """
    result = np.zeros((sum(map(len, rows)), *table.shape[1:]), dtype=np.float32)
    job = device.new_job()
    half = device.scratchpad_bytes // 2
    most = max(1, min(_MOST_ROWS, half // max(table[:1].nbytes, WORD_BYTES)))
    turns = Turns(range(device.tiles))
    done = 0
    for piece in rows:
        for start in range(0, len(piece), most):
            chosen = piece[start : start + most]
            tile, copy, freed = turns.take()
            moved = job.gather(tile, table, chosen, copy * half, after=freed)
            target = result[done : done + len(chosen)]
            turns.free(tile, copy, job.move_out(tile, copy * half, target, after=[moved]))
            done += len(chosen)
    if done:
        device.finish(ledger, stage, job)
    return result
