"""Pictures of ray-marched scenes, from batches of blocks of pixels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.march.crew import Batch, Work, share_out
from vividc.render.array.march.marching import SIDE, Marcher
from vividc.render.array.models.field import ArrayField
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera

BLOCKS_AT_ONCE: Final = 512


def render_blocks(
    device: Device,
    field: ArrayField,
    camera: Camera,
    corners: Int32Array,
    *,
    lookahead: bool = True,
    ledger: Ledger,
    progress: Callable[[float], None] | None = None,
    work: Work | None = None,
) -> Float32Array:
    """Return the picture [height, width, 3] over white; pixels of no block are white.

    Parameters
    ----------
    corners
        Of the blocks that are computed (`block_corners`).
    work
        The same frame for helpers, if other processes are to take part; the result is the same.
    """

    def tell(done: int) -> None:
        if progress is not None:
            progress(done / max(len(batches), 1))

    image = np.ones((camera.height, camera.width, 3), dtype=np.float32)
    render = batch_renderer(device, field, camera, lookahead=lookahead)
    batches = list(_batches(corners))
    for part, (pixels, cost) in zip(batches, share_out(work, batches, render, tell), strict=True):
        ledger.merge(cost)
        for (column, row), block in zip(part, pixels, strict=True):
            width, height = min(SIDE, camera.width - column), min(SIDE, camera.height - row)
            shown = block.reshape(SIDE, SIDE, 4)[:height, :width, :3]
            image[row : row + height, column : column + width] = shown
    return image


def batch_renderer(
    device: Device, field: ArrayField, camera: Camera, *, lookahead: bool
) -> Callable[[Int32Array], Batch]:
    """Return what renders batches of blocks."""
    marcher = Marcher(device, field, camera, lookahead)

    def render(corners: Int32Array) -> Batch:
        ledger = Ledger()
        return marcher.render(corners, ledger), ledger

    return render


def _batches(corners: Int32Array) -> Iterator[Int32Array]:
    for first in range(0, len(corners), BLOCKS_AT_ONCE):
        yield np.ascontiguousarray(corners[first : first + BLOCKS_AT_ONCE])
