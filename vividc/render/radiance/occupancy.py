"""Rays of a camera, and their samples in the occupied cells of a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.render.archive import Archive
from vividc.render.arrays import Float32Array, Int64Array
from vividc.render.camera import Camera

MOST_SAMPLES: Final = 8192
"""Of a ray; all rays of a block get room for so many."""
_HALF = np.float32(0.5)


@dataclass(frozen=True, slots=True, eq=False)
class March:
    """How a ray-marched model is sampled.

    Attributes
    ----------
    box
        [2, 3] float32: lowest and highest corner, world units.
    near, far
        Distances along a ray between which there are samples, world units.
    step
        Distance between samples, world units; sample k is at entry + (k + 1/2) step.
    samples
        Most samples of a ray.
    occupied
        [X, Y, Z] bool: cells of equal size in the box; only samples in set ones count.
    """

    box: Float32Array
    near: float
    far: float
    step: float
    samples: int
    occupied: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The samples of some rays, by ray and then by distance.

    Attributes
    ----------
    ray
        [n] int64 ray of each.
    points
        [n, 3] float32 positions in the world.
    """

    ray: Int64Array
    points: Float32Array


def read_march(archive: Archive) -> March:
    """Read the box, the steps and the occupancy bits, which all ray-marched layouts have.

    `occ_bits` holds cell (x, y, z) of `occ_shape` as bit (x * Y + y) * Z + z, the highest of each
    byte first.
    """
    box = archive.floats("aabb", (2, 3))
    if not (box[1] > box[0]).all():
        raise archive.error(f"aabb {box.tolist()} is not a lowest and a highest corner")
    shape = archive.integers("occ_shape", (3,))
    if (shape < 1).any():
        raise archive.error(f"occ_shape {shape.tolist()} is not positive")
    cells = int(np.prod(shape))
    packed = archive.integers("occ_bits", (None,))
    if len(packed) * 8 < cells:
        raise archive.error(
            f"occ_bits holds {len(packed) * 8} bits, fewer than the {cells} cells of occ_shape"
        )
    if ((packed < 0) | (packed > np.iinfo(np.uint8).max)).any():
        raise archive.error("occ_bits holds values that are no bytes")
    bits = np.unpackbits(packed.astype(np.uint8))[:cells].astype(np.bool_)
    bits.flags.writeable = False
    near = archive.number("near")
    samples = archive.whole("n_samples", above=0)
    if samples > MOST_SAMPLES:
        raise archive.error(f"n_samples is {samples}: a ray has at most {MOST_SAMPLES}")
    return March(
        box=box,
        near=near,
        far=archive.number("far", above=near),
        step=archive.number("step", above=0),
        samples=samples,
        occupied=bits.reshape(tuple(shape)),
    )


def pixel_rays(camera: Camera, first: int, count: int) -> Float32Array:
    """Return the unit directions [count, 3] of pixels `first`, first + 1, ... row by row.

    A ray goes through the centre of its pixel.
    """
    pixel = np.arange(first, first + count)
    return directions_of(camera, np.stack((pixel % camera.width, pixel // camera.width), axis=1))


def directions_of(camera: Camera, pixels: npt.NDArray[np.integer]) -> Float32Array:
    """Return the unit directions [n, 3] through the centres of pixels [n, 2]: column and row."""
    column, row = pixels.astype(np.float32).T
    focal = np.float32(camera.focal)
    right = (column + _HALF - np.float32(camera.width / 2)) / focal
    up = -(row + _HALF - np.float32(camera.height / 2)) / focal
    in_camera = np.stack((right, up, np.full_like(up, -1)), axis=1)
    direction: Float32Array = np.einsum("ij,nj->ni", camera.c2w[:3, :3], in_camera)
    length: Float32Array = np.sqrt(np.einsum("ni,ni->n", direction, direction))
    return direction / length[:, None]


def occupied_samples(march: March, origin: Float32Array, directions: Float32Array) -> Samples:
    """Return the samples in occupied cells of rays from `origin` [3] along `directions` [n, 3]."""
    entry, leave = box_span(march, origin, directions)
    rays = np.flatnonzero(leave > entry)
    steps = (np.arange(march.samples, dtype=np.float32) + _HALF) * np.float32(march.step)
    distance: Float32Array = entry[rays, None] + steps[None, :]
    ray, place = np.nonzero(distance <= leave[rays, None])
    along: Float32Array = distance[ray, place, None]
    points: Float32Array = origin + along * directions[rays[ray]]
    shape = np.array(march.occupied.shape, dtype=np.float32)
    cell = np.floor(in_box(march.box, points) * shape).astype(np.int64)
    inside = ((cell >= 0) & (cell < march.occupied.shape)).all(axis=1)
    kept = np.flatnonzero(inside)
    kept = kept[march.occupied[tuple(cell[kept].T)]]
    return Samples(rays[ray[kept]], points[kept])


def in_box(box: Float32Array, points: Float32Array) -> Float32Array:
    """Return points [n, 3] in coordinates of the box, 0 to 1."""
    place: Float32Array = (points - box[0]) / (box[1] - box[0])
    return place


def box_span(
    march: March, origin: Float32Array, directions: Float32Array
) -> tuple[Float32Array, Float32Array]:
    """Return where each ray enters and leaves the box (slabs; Kay and Kajiya 1986), [n] each.

    A ray along the plane of a face gives 0/0 there; that bounds nothing, as the other face.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        low = (march.box[0] - origin) / directions
        high = (march.box[1] - origin) / directions
    low, high = np.where(np.isnan(low), -high, low), np.where(np.isnan(high), -low, high)
    entry: Float32Array = np.fmax.reduce(np.fmin(low, high), axis=1)
    leave: Float32Array = np.fmin.reduce(np.fmax(low, high), axis=1)
    near, far = np.float32(march.near), np.float32(march.far)
    return np.fmin(np.fmax(entry, near), far), leave
