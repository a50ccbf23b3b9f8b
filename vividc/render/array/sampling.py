"""Which blocks of pixels are simulated when not all are."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.render.arrays import Int32Array
from vividc.render.camera import Camera
from vividc.render.radiance import March, directions_of, occupied_samples

_PLACES: Final = (1, 3, 5, 7)
"""Rows and columns of a block whose rays are marched to know its work."""
_BLOCKS_AT_ONCE: Final = 512


def sampled(work: npt.NDArray[np.number], share: float) -> Int32Array:
    """Return the numbers of about a share of the blocks, in ascending order; at least one.

    Systematic sampling in the order of their work (Madow and Madow 1944): the blocks are cut into
    strata of equal size from the least work to the most, and the middle one of each is taken. So
    their mean is that of all blocks but for what blocks of about equal work differ in.

    Parameters
    ----------
    work
        [blocks] what each is expected to cost, in any unit.
    share
        Above 0, at most 1.
    """
    count = max(round(share * len(work)), min(len(work), 1))
    order = np.argsort(work, kind="stable")
    middle = ((np.arange(count) + 0.5) * (len(work) / max(count, 1))).astype(np.int64)
    return np.sort(order[middle]).astype(np.int32)


def expected_samples(march: March, camera: Camera, corners: Int32Array) -> npt.NDArray[np.int64]:
    """Return the samples in occupied cells of sixteen rays of each block of 8x8 pixels, [blocks].

    Parameters
    ----------
    corners
        [blocks, 2] first column and row of each.
    """
    inside = np.stack(np.meshgrid(_PLACES, _PLACES), axis=-1).reshape(-1, 2)
    counts = [np.zeros(0, dtype=np.int64)]
    for first in range(0, len(corners), _BLOCKS_AT_ONCE):
        part = corners[first : first + _BLOCKS_AT_ONCE]
        pixels = (part[:, None] + inside).reshape(-1, 2)
        samples = occupied_samples(march, camera.position, directions_of(camera, pixels))
        ray = np.bincount(samples.ray, minlength=len(pixels))
        counts.append(ray.reshape(len(part), -1).sum(axis=1))
    return np.concatenate(counts)


def pixels_of(corners: Int32Array, side: int, camera: Camera) -> npt.NDArray[np.bool_]:
    """Return which pixels are in blocks of `side` x `side` pixels with these corners, [height,
    width].
    """
    inside = np.zeros((camera.height, camera.width), dtype=np.bool_)
    for column, row in corners:
        inside[row : row + side, column : column + side] = True
    return inside
