"""Pictures of ray-marched scenes, from batches of blocks of pixels."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Final

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.march.crew import Batch, Work, share_out
from vividc.render.array.march.depths import Blocks, seen_blocks
from vividc.render.array.march.marching import Marcher, steps_of
from vividc.render.array.models.field import ArrayField
from vividc.render.array.options import ArrayOptions
from vividc.render.array.pieces import SIDE
from vividc.render.array.steering import BLOCKS_AT_ONCE, FIRST_BATCH
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera
from vividc.render.radiance import March

_DEFAULT: Final = ArrayOptions()


def render_blocks(
    device: Device,
    field: ArrayField,
    camera: Camera,
    corners: Int32Array,
    *,
    options: ArrayOptions = _DEFAULT,
    progress: Callable[[float], None] | None = None,
    work: Work | None = None,
) -> tuple[Float32Array, Ledger]:
    """Return the picture [height, width, 3] over white, and what it cost; pixels of no block, and
    of blocks that see no brick of the occupancy, are white.

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
    render = batch_renderer(device, field, camera, options)
    device.settle()  # of what failed before
    seen = seen_blocks(device, field.march, camera, corners)
    ledger = device.settle()
    for stage in ledger.stages.values():
        stage.once = True
    ledger.count(rays=int(inside.prod(axis=1).sum()), empty_blocks=len(corners) - len(seen))
    batches = batches_of(field.march, seen)
    for part, (pixels, cost) in zip(batches, share_out(work, batches, render, tell), strict=True):
        ledger.merge(cost)
        for (column, row), block in zip(part.corners, pixels, strict=True):
            width, height = min(SIDE, camera.width - column), min(SIDE, camera.height - row)
            shown = block.reshape(SIDE, SIDE, 4)[:height, :width, :3]
            image[row : row + height, column : column + width] = shown
    return image, ledger


def batches_of(march: March, blocks: Blocks) -> list[Blocks]:
    """Return blocks in batches of about as many steps of rays, of at most `BLOCKS_AT_ONCE` on
    average. The first one is smaller: helpers wait for it, as its kernels are compiled.
    """
    number = batch_count(len(blocks))
    steps = np.cumsum(steps_of(march, blocks))
    ends = (np.arange(number - 1) + FIRST_BATCH) / (number - 1 + FIRST_BATCH)
    cuts = np.unique([0, *np.searchsorted(steps, ends * steps[-1:]), len(blocks)])
    return [blocks[first:last] for first, last in pairwise(cuts.tolist())]


def batch_count(blocks: int) -> int:
    """Return in how many batches so many blocks are rendered: of more than two, an even number is
    behind the first one, for two processes.
    """
    number = -(-blocks // BLOCKS_AT_ONCE)
    return number + (number > 2 and number % 2 == 0)  # noqa: PLR2004 - less than two behind it


def batch_renderer(
    device: Device, field: ArrayField, camera: Camera, options: ArrayOptions
) -> Callable[[Blocks], Batch]:
    """Return what renders batches of blocks."""
    marcher = Marcher(device, field, camera, options)

    def render(blocks: Blocks) -> Batch:
        device.settle()  # of what failed before
        return marcher.render(blocks), device.settle()

    return render
