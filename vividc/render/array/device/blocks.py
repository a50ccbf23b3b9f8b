"""Rows in blocks of 16, as networks take them, and kernels over blocks: cut into launches of
several blocks, spread over the tiles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, Final, TypeVar

import numpy as np
import numpy.typing as npt

from vividc.launch.turns import neighbours
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch, Words
from vividc.render.array.steering import LAUNCHES_OF_BLOCKS

BLOCK: Final = 16
"""Rows of a block."""

Word = TypeVar("Word", bound=np.generic)


def in_blocks(rows: npt.NDArray[Word]) -> npt.NDArray[Word]:
    """Return rows [n, F] as blocks [B, 16, F], the last one filled up with its last row."""
    missing = -len(rows) % BLOCK
    if missing:
        rows = np.concatenate((rows, np.repeat(rows[-1:], missing, axis=0)))
    return np.ascontiguousarray(rows).reshape(len(rows) // BLOCK, BLOCK, rows.shape[1])


def batches(most: int, *arrays: npt.NDArray[Any]) -> Iterator[tuple[slice, list[npt.NDArray[Any]]]]:
    """Yield where the blocks of at most `most` rows, a multiple of 16, lie among all blocks, and
    those of each array.
    """
    for first in range(0, len(arrays[0]), most):
        blocks = [in_blocks(rows[first : first + most]) for rows in arrays]
        yield slice(first // BLOCK, first // BLOCK + len(blocks[0])), blocks


def run_blocks(
    device: Device,
    stage: str,
    kernel: str,
    inputs: Mapping[str, Words],
    outputs: Mapping[str, Words],
    scalars: Mapping[str, object] | None = None,
    shared: Mapping[str, Words] | None = None,
) -> None:
    """Run a kernel over blocks, neighbours on one tile; outputs are updated in place.

    Parameters
    ----------
    kernel
        As in `Programs.get`. Its parameter `blocks`, if it has one, gets the blocks of a launch.
    inputs, outputs
        By parameter, [B, ...] of four bytes each: a launch gets the rows of its blocks, flat if the
        parameter has one dimension.
    scalars, shared
        Other parameters, and arrays that all launches get.

    Raises
    ------
    SceneError
        Not even one block fits a scratchpad.
    """
    common, held = dict(scalars or {}), dict(shared or {})
    counts = any(p.name == "blocks" for p in device.programs.get(kernel).params)
    line = device.line_bytes // WORD_BYTES
    arrays = (*inputs.values(), *outputs.values())
    most = device.fitting(
        record=sum(array[0].size for array in arrays),
        held=sum(array.size + line for array in held.values()),
        arrays=len(arrays),
    )

    def launch(first: int, last: int) -> Launch:
        return Launch(
            inputs={name: array[first:last] for name, array in inputs.items()},
            outputs={name: array[first:last] for name, array in outputs.items()},
            scalars={"blocks": last - first, **common} if counts else common,
            shared=held,
        )

    shares = []
    for first, last in neighbours(len(arrays[-1]), device.tiles):
        at_once = max(1, min(most, -(-(last - first) // LAUNCHES_OF_BLOCKS)))
        cuts = [*range(first, last, at_once), last]
        shares.append([launch(*span) for span in pairwise(cuts)])
    device.run_shares(stage, kernel, shares)
