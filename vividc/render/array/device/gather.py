"""Rows of arrays chosen by indices, and pieces of arrays: DMA into scratchpads, and out again
contiguously.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import Turns
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger

Word = TypeVar("Word", bound=np.generic)

_MOST_ROWS = 128


def gather_rows(
    device: Device,
    ledger: Ledger,
    stage: str,
    table: npt.NDArray[Word],
    rows: Sequence[npt.NDArray[np.int32]],
) -> npt.NDArray[Word]:
    """Return `table[rows]` for the rows of all pieces, one after the other.

    Parameters
    ----------
    table
        [n, ...] words of four bytes; a row fits half a scratchpad.
    rows
        Pieces of indices, wherever they are in DRAM.
    """
    result = np.zeros((sum(map(len, rows)), *table.shape[1:]), dtype=table.dtype)
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


def joined(
    device: Device, ledger: Ledger, stage: str, pieces: Sequence[npt.NDArray[Word]]
) -> npt.NDArray[Word]:
    """Return rows of several arrays, at least one, one after the other.

    Parameters
    ----------
    pieces
        [n, ...] words of four bytes, contiguous; a row fits half a scratchpad.
    """
    result = np.zeros((sum(map(len, pieces)), *pieces[0].shape[1:]), dtype=pieces[0].dtype)
    job = device.new_job()
    half = device.scratchpad_bytes // 2
    most = max(1, half // max(result[:1].nbytes, WORD_BYTES))
    turns = Turns(range(device.tiles))
    done = 0
    for piece in pieces:
        for start in range(0, len(piece), most):
            part = piece[start : start + most]
            tile, copy, freed = turns.take()
            moved = job.move_in(tile, part, copy * half, after=freed)
            target = result[done : done + len(part)]
            turns.free(tile, copy, job.move_out(tile, copy * half, target, after=[moved]))
            done += len(part)
    if done:
        device.finish(ledger, stage, job)
    return result
