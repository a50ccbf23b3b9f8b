"""Blocks of pixels that see a brick of the occupancy, and between which distances.

No ray of another block has a sample, and no ray has one elsewhere: bricks are projected with more
slack than the rounding of a sample's place (kernels/render/block_depths.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch
from vividc.render.array.march.bricks import BRICK, pack_bricks
from vividc.render.array.pieces import SIDE
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera
from vividc.render.radiance import March

STAGE: Final = "block depths"
_EVERYWHERE: Final = (0.0, 3e38)
_LIST: Final = 256
"""Words of each of the two lists that the kernel works in."""
_SPARE_WORDS: Final = 256
_SLACK: Final = 2.0**-18
"""Of the largest coordinate: 32 times the last bit of a float32."""
_SLACK_PX: Final = 1 / 16
_COORDINATES: Final = (1e-12, 1e12)
"""The largest one is between these: squares are neither 0 nor infinite."""
_LARGEST_CONDITION: Final = 4.0
"""Of a camera's matrix; that of a rotation is 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """Blocks of 8x8 pixels.

    Attributes
    ----------
    corners
        [n, 2] int32 first column and row.
    depths
        [n, 2] float32 distances from the camera between which their samples are.
    """

    corners: Int32Array
    depths: Float32Array

    def __len__(self) -> int:
        return len(self.corners)

    def __getitem__(self, chosen: slice | npt.NDArray[np.generic]) -> Blocks:
        return Blocks(
            np.ascontiguousarray(self.corners[chosen]), np.ascontiguousarray(self.depths[chosen])
        )


def block_corners(camera: Camera) -> Int32Array:
    """Return the first column and row of each block of 8x8 pixels, [n, 2] int32, row by row."""
    columns = np.arange(0, camera.width, SIDE)
    rows = np.arange(0, camera.height, SIDE)
    corners = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    return corners.astype(np.int32)


def seen_blocks(device: Device, march: March, camera: Camera, corners: Int32Array) -> Blocks:
    """Return those of some blocks that see a brick.

    Which distances all blocks of the picture see is a stage of the frame, booked as a whole one.
    Where bricks or the camera's matrix are such that float32 might lose a sample, all blocks are
    returned, with all distances.
    """
    view, places = _view(march, camera), pack_bricks(march.occupied).places
    if view is None or places is None:
        depths = np.tile(np.array(_EVERYWHERE, dtype=np.float32), (len(corners), 1))
        return Blocks(corners, depths)
    nearest, farthest = _depths(device, view, camera, places)
    column, row = corners.T // SIDE
    depths = np.stack((nearest[row, column], farthest[row, column]), axis=1)
    return Blocks(corners, depths)[depths[:, 1] > 0]


def _depths(
    device: Device, view: Float32Array, camera: Camera, places: npt.NDArray[np.uint32]
) -> tuple[Float32Array, Float32Array]:
    """Return the least and the greatest distance of each block, [rows, columns]."""
    rows, columns = -(-camera.height // SIDE), -(-camera.width // SIDE)
    nearest = np.zeros((rows, columns), dtype=np.float32)
    farthest = np.full((rows, columns), -1, dtype=np.float32)
    if not len(places):
        return nearest, farthest
    words = device.scratchpad_bytes // WORD_BYTES - len(places) - 2 * _LIST - _SPARE_WORDS
    at_once = max(1, min(-(-rows // device.tiles), words // (2 * columns)))
    shared = {"view": view, "bricks": places}
    launches = []
    for first in range(0, rows, at_once):
        strip = slice(first, first + at_once)
        launches.append(
            Launch(
                work={"spans": (_LIST,), "depths": (_LIST,)},
                outputs={
                    "nearest": nearest[strip].reshape(-1),
                    "farthest": farthest[strip].reshape(-1),
                },
                shared=shared,
                scalars={
                    "columns": columns,
                    "first_row": first,
                    "rows": len(nearest[strip]),
                },
            )
        )
    device.run(STAGE, "render/block_depths:block_depths", launches)
    device.ledger.stages[STAGE].whole = True
    device.ledger.count(words_read_by_host=nearest.size + farthest.size)
    return nearest, farthest


def _view(march: March, camera: Camera) -> Float32Array | None:
    """Return the table that the kernel calls `view`; None: it cannot be relied on, as the
    camera's matrix is far from a rotation, or coordinates are near the ends of float32.
    """
    matrix = camera.c2w[:3, :3].astype(np.float64)
    origin = camera.position.astype(np.float64)
    low, high = march.box.astype(np.float64)
    with np.errstate(all="ignore"):
        condition = np.linalg.cond(matrix)
    if not condition <= _LARGEST_CONDITION:
        return None
    inverse = np.linalg.inv(matrix)
    sides = BRICK * (high - low) / march.occupied.shape
    largest = max(np.abs(low).max(), np.abs(high).max(), np.abs(origin).max(), sides.max())
    if not _COORDINATES[0] < largest < _COORDINATES[1]:
        return None
    slack = _SLACK * largest
    half = sides / 2 + slack
    picture = np.array((camera.width, camera.height), dtype=np.float64)
    parts = (
        *(origin, low + sides / 2, sides, half, inverse.ravel(), np.abs(inverse) @ half),
        *((camera.focal,), picture / 2 - 0.5, (picture / 2 + 1) / camera.focal),
        (_SLACK_PX + 2 * _SLACK * camera.focal,),
    )
    return np.concatenate(parts).astype(np.float32)
