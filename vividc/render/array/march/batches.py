"""Pictures of ray-marched scenes, from batches of blocks of pixels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.march.crew import Batch, Work, share_out
from vividc.render.array.march.depths import Blocks, seen_blocks
from vividc.render.array.march.marching import Marcher
from vividc.render.array.models.field import ArrayField
from vividc.render.array.options import ArrayOptions
from vividc.render.array.pieces import SIDE
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera

BLOCKS_AT_ONCE: Final = 512
_DEFAULT: Final = ArrayOptions()


def render_blocks(
    device: Device,
    field: ArrayField,
    camera: Camera,
    corners: Int32Array,
    *,
    options: ArrayOptions = _DEFAULT,
    ledger: Ledger,
    progress: Callable[[float], None] | None = None,
    work: Work | None = None,
) -> Float32Array:
    """Return the picture [height, width, 3] over white; pixels of no block, and of blocks that see
    no brick of the occupancy, are white.

    Parameters
    ----------
    corners
        Of the blocks that are computed (`block_corners`).
    options
        Those that say which samples' colours are computed, and count.
    work
        The same frame for helpers, if other processes are to take part; the result is the same.
    """

    def tell(done: int) -> None:
        if progress is not None:
            progress(done / max(len(batches), 1))

    image = np.ones((camera.height, camera.width, 3), dtype=np.float32)
    inside = np.minimum((camera.width, camera.height) - corners, SIDE)
    ledger.count(rays=int(inside.prod(axis=1).sum()))
    render = batch_renderer(device, field, camera, options)
    seen = seen_blocks(device, ledger, field.march, camera, corners)
    ledger.count(empty_blocks=len(corners) - len(seen))
    batches = list(_batches(seen))
    for part, (pixels, cost) in zip(batches, share_out(work, batches, render, tell), strict=True):
        ledger.merge(cost)
        for (column, row), block in zip(part.corners, pixels, strict=True):
            width, height = min(SIDE, camera.width - column), min(SIDE, camera.height - row)
            shown = block.reshape(SIDE, SIDE, 4)[:height, :width, :3]
            image[row : row + height, column : column + width] = shown
    return image


def batch_renderer(
    device: Device, field: ArrayField, camera: Camera, options: ArrayOptions
) -> Callable[[Blocks], Batch]:
    """Return what renders batches of blocks."""
    marcher = Marcher(device, field, camera, options)

    def render(blocks: Blocks) -> Batch:
        ledger = Ledger()
        return marcher.render(blocks, ledger), ledger

    return render


def _batches(blocks: Blocks) -> Iterator[Blocks]:
    for first in range(0, len(blocks), BLOCKS_AT_ONCE):
        yield blocks[first : first + BLOCKS_AT_ONCE]
