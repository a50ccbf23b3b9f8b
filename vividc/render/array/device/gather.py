"""Rows of arrays chosen by indices: DMA into scratchpads, and out again contiguously."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Gathered, Launch
from vividc.render.array.device.launches import in_turn
from vividc.render.array.steering import GATHERED_ROWS

Word = TypeVar("Word", bound=np.generic)


def gather_rows(
    device: Device, stage: str, table: npt.NDArray[Word], rows: Sequence[npt.NDArray[np.int32]]
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
    most = max(1, min(GATHERED_ROWS, device.fitting(max(table[:1].size, 1))))
    launches: list[Launch] = []
    done = 0
    for piece in rows:
        for start in range(0, len(piece), most):
            chosen = piece[start : start + most]
            target = result[done : done + len(chosen)]
            launches.append(
                Launch(inputs={"rows": Gathered(table, chosen)}, outputs={"rows": target})
            )
            done += len(chosen)
    device.run_shares(stage, None, in_turn(launches, device.tiles))
    return result
