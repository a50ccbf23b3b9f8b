"""The 3DGS stages before blending: EWA projection, tile binning and depth sort, in float32.

Source of every formula and constant: Kerbl et al., 3D Gaussian Splatting (2023), reference
rasteriser; the projection is that of Zwicker et al., EWA Volume Splatting (2001).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from vividc.errors import demand_type
from vividc.render.arrays import Float32Array, Int64Array, frozen_float32
from vividc.render.camera import Camera
from vividc.render.crop import TILE_PX
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.splat.spherical_harmonics import sh_colour

_NEAR_DEPTH = np.float32(0.2)
_FOV_MARGIN = np.float32(1.3)
_LOW_PASS_PX2 = np.float32(0.3)
_RADIUS_SIGMAS = np.float32(3.0)
_MIN_EIGEN_SPREAD = np.float32(0.1)


@dataclass(frozen=True, slots=True, eq=False)
class Splats:
    """n projected Gaussians as a structure of arrays, each float32[n].

    Attributes
    ----------
    mean_x, mean_y
        Centre in pixels; pixel (0, 0) has its centre at 0.
    conic_a, conic_b, conic_c
        Inverse 2D covariance [[a, b], [b, c]], 1/pixel^2.
    opacity
        Peak opacity 0..1.
    red, green, blue
        Colour seen from the camera, at least 0.
    """

    mean_x: Float32Array
    mean_y: Float32Array
    conic_a: Float32Array
    conic_b: Float32Array
    conic_c: Float32Array
    opacity: Float32Array
    red: Float32Array
    green: Float32Array
    blue: Float32Array

    def __len__(self) -> int:
        return len(self.mean_x)

    def arrays(self) -> dict[str, Float32Array]:
        """Return the nine arrays by name, in the order of the fields."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def take(self, indices: Int64Array) -> Splats:
        """Return the splats `indices`, in that order."""
        return Splats(*(frozen_float32(array[indices]) for array in self.arrays().values()))


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """The m Gaussians in front of a camera whose footprint meets the image.

    Attributes
    ----------
    splats
        Projected Gaussians in scene order.
    depth
        [m] float32 distance along the viewing axis, world units.
    radius
        [m] float32 whole pixels; the footprint is the square of this half side.
    index
        [m] int64 row of each in the scene.
    """

    splats: Splats
    depth: Float32Array
    radius: Float32Array
    index: Int64Array


@dataclass(frozen=True, slots=True, eq=False)
class TileLists:
    """The splats of each screen tile, front to back.

    Attributes
    ----------
    splats
        All visible splats.
    width, height
        Image size in pixels.
    order
        [entries] int64 indices into `splats`, grouped by tile, by depth within a tile.
    start
        [tiles + 1] int64; tile t (row-major) owns `order[start[t]:start[t + 1]]`.
    """

    splats: Splats
    width: int
    height: int
    order: Int64Array
    start: Int64Array

    @property
    def lengths(self) -> Int64Array:
        """[tile rows, tile columns] number of splats in each tile's list."""
        return np.diff(self.start).reshape(_tile_grid(self.width, self.height)[::-1])

    def tile(self, tile_x: int, tile_y: int) -> Splats:
        """Return the depth-sorted splats of one tile."""
        columns, rows = _tile_grid(self.width, self.height)
        if not (0 <= tile_x < columns and 0 <= tile_y < rows):
            raise SceneError(f"tile ({tile_x}, {tile_y}) is outside the {columns}x{rows} tiles")
        tile = tile_y * columns + tile_x
        return self.splats.take(self.order[self.start[tile] : self.start[tile + 1]])


def tile_lists(gaussians: Gaussians, camera: Camera) -> TileLists:
    """Project a scene, bin it into 16x16 screen tiles and sort each tile's list by depth."""
    demand_type(gaussians, Gaussians, "the Gaussians", "give what read_gaussians gave")
    demand_type(camera, Camera, "the camera", "give a Camera, as orbit_camera makes one")
    return bin_and_sort(project(gaussians, camera), camera.width, camera.height)


def project(gaussians: Gaussians, camera: Camera) -> Projection:
    """Project the Gaussians (EWA), and drop those before the near plane or off the image."""
    view = _transform(camera.world_to_view, gaussians.means)
    index = np.flatnonzero(view[:, 2] > _NEAR_DEPTH)
    view = view[index]
    # A Gaussian too large for float32 overflows here and is dropped with the singular ones.
    with np.errstate(over="ignore", invalid="ignore"):
        covariance = _covariance_2d(gaussians, camera, view, index)
        conic, radius = _conic_and_radius(covariance)
    mean = _pixel_position(camera, view)
    first, last = _tile_span(mean, radius, camera.width, camera.height)
    seen = (last > first).all(axis=1) & np.isfinite(conic).all(axis=1)
    colour = sh_colour(gaussians.sh[index], _directions(gaussians.means[index], camera))
    columns = (*mean.T, *conic.T, gaussians.opacity[index], *colour.T)
    return Projection(
        splats=Splats(*(frozen_float32(column[seen]) for column in columns)),
        depth=frozen_float32(view[seen, 2]),
        radius=frozen_float32(radius[seen]),
        index=index[seen],
    )


def bin_and_sort(projection: Projection, width: int, height: int) -> TileLists:
    """Give every tile the splats whose footprint meets it, sorted by depth, scene order on ties.

    The sort key is (tile << 32) | bits of the float32 depth, as in the reference: depths are
    positive, so their bit patterns sort as the numbers do.
    """
    splats = projection.splats
    mean = np.stack((splats.mean_x, splats.mean_y), axis=1)
    first, last = _tile_span(mean, projection.radius, width, height)
    columns, rows = _tile_grid(width, height)
    span = last - first
    copies = span[:, 0] * span[:, 1]
    splat = np.repeat(np.arange(len(splats)), copies)
    within = np.arange(len(splat)) - np.repeat(np.cumsum(copies) - copies, copies)
    tile_x = first[splat, 0] + within % span[splat, 0]
    tile_y = first[splat, 1] + within // span[splat, 0]
    tile = tile_y * columns + tile_x
    depth_bits = projection.depth.view(np.uint32).astype(np.int64)
    order = np.argsort((tile << 32) | depth_bits[splat], kind="stable")
    start = np.zeros(columns * rows + 1, dtype=np.int64)
    np.cumsum(np.bincount(tile, minlength=columns * rows), out=start[1:])
    return TileLists(splats, width, height, splat[order], start)


def _tile_grid(width: int, height: int) -> tuple[int, int]:
    return -(-width // TILE_PX), -(-height // TILE_PX)


def _transform(matrix: Float32Array, points: Float32Array) -> Float32Array:
    rotated: Float32Array = np.einsum("ij,nj->ni", matrix[:, :3], points)
    return rotated + matrix[:, 3]


def _directions(means: Float32Array, camera: Camera) -> Float32Array:
    offset = means - camera.position
    distance: Float32Array = np.sqrt(np.einsum("ni,ni->n", offset, offset))
    return offset / distance[:, None]


def _pixel_position(camera: Camera, view: Float32Array) -> Float32Array:
    size = np.array([camera.width, camera.height], dtype=np.float32)
    centre = (size - np.float32(1)) / np.float32(2)
    slope: Float32Array = view[:, :2] / view[:, 2:]
    return np.float32(camera.focal) * slope + centre


def _rotation_matrices(quaternions: Float32Array) -> Float32Array:
    """Return [N, 3, 3] from unit quaternions w, x, y, z."""
    w, x, y, z = quaternions.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def _covariance_2d(
    gaussians: Gaussians, camera: Camera, view: Float32Array, index: Int64Array
) -> Float32Array:
    """Return J W S W^T J^T with the low-pass added, as [M, 3] (xx, xy, yy) in pixel^2."""
    focal = np.float32(camera.focal)
    size = np.array([camera.width, camera.height], dtype=np.float32)
    depth = view[:, 2]
    limit = _FOV_MARGIN * size / (2 * focal)
    slope = np.clip(view[:, :2] / depth[:, None], -limit, limit)
    jacobian = np.zeros((len(view), 2, 3), dtype=np.float32)
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = focal / depth
    # -f x / z^2 with the clamped x/z: the affine approximation diverges far off screen.
    jacobian[:, :, 2] = -focal * slope / depth[:, None]
    axes = _rotation_matrices(gaussians.rotations[index]) * gaussians.scales[index, None, :]
    view_axes = np.einsum("ij,njk->nik", camera.world_to_view[:, :3], axes)
    screen_axes = np.einsum("nij,njk->nik", jacobian, view_axes)
    across, down = screen_axes[:, 0], screen_axes[:, 1]
    xx = np.einsum("ni,ni->n", across, across) + _LOW_PASS_PX2
    xy = np.einsum("ni,ni->n", across, down)
    yy = np.einsum("ni,ni->n", down, down) + _LOW_PASS_PX2
    return np.stack((xx, xy, yy), axis=1)


def _conic_and_radius(covariance: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Return the inverse [M, 3] (a, b, c) and the radius [M] in whole pixels.

    Where rounding or overflow left no invertible covariance the conic is nan, the radius 0.
    """
    xx, xy, yy = covariance.T
    determinant = xx * yy - xy * xy
    usable = (determinant > 0) & np.isfinite(determinant)
    divisor: Float32Array = np.where(usable, determinant, np.float32(np.nan))
    adjugate: Float32Array = np.stack((yy, -xy, xx), axis=1)
    conic: Float32Array = adjugate / divisor[:, None]
    middle = np.float32(0.5) * (xx + yy)
    spread = np.sqrt(np.maximum(_MIN_EIGEN_SPREAD, middle * middle - determinant))
    radius = np.ceil(_RADIUS_SIGMAS * np.sqrt(middle + spread))
    return conic, np.where(usable & np.isfinite(radius), radius, np.float32(0))


def _tile_span(
    mean: Float32Array, radius: Float32Array, width: int, height: int
) -> tuple[Int64Array, Int64Array]:
    """Return first and one-past-last tile [M, 2] (column, row) of each square footprint."""
    tiles = np.array(_tile_grid(width, height), dtype=np.float32)
    reach = radius[:, None]
    first = np.clip((mean - reach) / TILE_PX, 0, tiles)
    last = np.clip((mean + reach + (TILE_PX - 1)) / TILE_PX, 0, tiles)
    return first.astype(np.int64), last.astype(np.int64)
