"""The kernels of `kernels/render/`: the Gaussian stages on splats of scenes/mic, the others on
made-up inputs with fixed seeds.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.general import Maker
from benchmarks.workloads import Arguments, Workload
from vividc.render import Camera, Gaussians, Projection, load_cameras, project, read_gaussians

MIC = Path(__file__).resolve().parents[1] / "scenes" / "mic"
SPLATS = 64
FOV_MARGIN = 1.3
OCCUPIED_SHARE = 0.1
TILE_PX = 16


@cache
def mic_camera() -> Camera:
    """The first held-out view, 200x200."""
    return load_cameras(MIC / "ref_gs.npz")[0]


@cache
def mic_gaussians() -> Gaussians:
    return read_gaussians(MIC / "mic_3dgs_sh3.ply")


@cache
def mic_projection() -> Projection:
    return project(mic_gaussians(), mic_camera())


def some(rng: np.random.Generator, count: int = SPLATS) -> np.ndarray:
    """[count] positions in the projection, ascending."""
    visible = len(mic_projection().splats)
    return np.sort(rng.choice(visible, count, replace=False))


def view_matrix() -> np.ndarray:
    """[3, 4] float32 world to camera."""
    return np.ascontiguousarray(mic_camera().world_to_view)


def view_limit(camera: Camera, pixels: int) -> np.float32:
    """The largest x/z or y/z kept by the projection: 1.3 times the tangent of half the field."""
    return np.float32(FOV_MARGIN * pixels / (2 * camera.focal))


def covariances(gaussians: Gaussians, index: np.ndarray) -> np.ndarray:
    """[n, 6] float32 world covariances xx, xy, xz, yy, yz, zz."""
    w, x, y, z = gaussians.rotations[index].astype(np.float64).T
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    axes = rotation * gaussians.scales[index].T
    full = np.einsum("ikn,jkn->nij", axes, axes)
    return np.ascontiguousarray(full[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]], np.float32)


def screen_covariances(index: np.ndarray) -> np.ndarray:
    """[n, 3] float32 inverses of the conics: xx, xy, yy in pixel^2."""
    splats = mic_projection().splats
    a, b, c = (
        v[index].astype(np.float64) for v in (splats.conic_a, splats.conic_b, splats.conic_c)
    )
    determinant = a * c - b * b
    return np.ascontiguousarray(np.stack((c, -b, a), axis=1) / determinant[:, None], np.float32)


def _blank(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.float32)


def _zeros(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.int32)


def _floats(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.standard_normal(shape).astype(np.float32)


def _between(rng: np.random.Generator, low: float, high: float, *shape: int) -> np.ndarray:
    return rng.uniform(low, high, shape).astype(np.float32)


def _directions(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.standard_normal((count, 3))
    lengths = np.sqrt(np.einsum("ni,ni->n", vectors, vectors))
    return (vectors / lengths[:, None]).astype(np.float32)


def _project_means(rng: np.random.Generator) -> Arguments:
    camera = mic_camera()
    means = mic_gaussians().means[mic_projection().index[some(rng)]]
    centre = np.float32((camera.width - 1) / 2), np.float32((camera.height - 1) / 2)
    focal = np.float32(camera.focal)
    return means, view_matrix(), focal, *centre, _blank(SPLATS, 2), _blank(SPLATS)


def _covariance_3d(rng: np.random.Generator) -> Arguments:
    gaussians, index = mic_gaussians(), mic_projection().index[some(rng)]
    return gaussians.scales[index], gaussians.rotations[index], _blank(SPLATS, 6)


def _covariance_2d(rng: np.random.Generator) -> Arguments:
    camera, gaussians = mic_camera(), mic_gaussians()
    index = mic_projection().index[some(rng)]
    limits = view_limit(camera, camera.width), view_limit(camera, camera.height)
    return (
        gaussians.means[index],
        covariances(gaussians, index),
        view_matrix(),
        np.float32(camera.focal),
        *limits,
        _blank(SPLATS, 3),
    )


def _sh_colour(rng: np.random.Generator) -> Arguments:
    gaussians, index = mic_gaussians(), mic_projection().index[some(rng)]
    offset = gaussians.means[index] - mic_camera().position
    distance = np.sqrt(np.einsum("ni,ni->n", offset, offset))
    return offset / distance[:, None], np.ascontiguousarray(gaussians.sh[index]), _blank(SPLATS, 3)


def _tile_bounds(rng: np.random.Generator) -> Arguments:
    projection, index = mic_projection(), some(rng)
    pixel = np.stack((projection.splats.mean_x, projection.splats.mean_y), axis=1)[index]
    tiles = [np.int32(-(-size // TILE_PX)) for size in (mic_camera().width, mic_camera().height)]
    return pixel, projection.radius[index], *tiles, _zeros(SPLATS, 4), _zeros(SPLATS)


def _tile_entries(rng: np.random.Generator) -> Arguments:
    first = rng.integers(0, 11, (SPLATS, 2))
    last = first + rng.integers(0, 3, (SPLATS, 2))
    copies = np.prod(last - first, axis=1).astype(np.int32)
    depth = mic_projection().depth[some(rng)].view(np.uint32)
    entries = int(copies.sum())
    keys = np.zeros(entries, np.uint32), np.zeros(entries, np.uint32)
    bounds = np.concatenate((first, last), axis=1).astype(np.int32)
    return bounds, copies, depth, np.int32(13), *keys, _zeros(entries)


def _depth_bits(rng: np.random.Generator) -> np.ndarray:
    return rng.permutation(mic_projection().depth[some(rng, 200)]).view(np.uint32)


def _radix_scatter(rng: np.random.Generator) -> Arguments:
    keys, shift = _depth_bits(rng), 16
    counts = np.bincount((keys >> np.uint32(shift)) & np.uint32(15), minlength=16)
    offsets = (np.cumsum(counts) - counts).astype(np.int32)
    values = np.arange(len(keys), dtype=np.int32)
    outputs = np.zeros(len(keys), np.uint32), _zeros(len(keys))
    return keys, values, np.int32(shift), offsets, *outputs


def _march_occupancy(rng: np.random.Generator) -> Arguments:
    """A ray through a grid of 32^3 cells, few of them occupied."""
    bits = rng.random(32**3) < OCCUPIED_SHARE
    occupied = np.packbits(bits, bitorder="little").view(np.uint32)
    origin = np.array([-2.0, 5.5, 9.25], np.float32)
    direction = np.array([0.8, 0.48, 0.36], np.float32)
    shape = np.array([32, 32, 32], np.int32)
    span = np.float32(2.5), np.float32(50.0), np.float32(math.sqrt(3) / 8)
    return origin, direction, *span, occupied, shape, _blank(64)


def _ray_box(rng: np.random.Generator) -> Arguments:
    box = np.array([[-1, -1, -1], [1, 1, 1]], np.float32)
    limits = np.float32(0.0), np.float32(100.0)
    origins = _between(rng, -3, 3, SPLATS, 3)
    return origins, _directions(rng, SPLATS), box, *limits, _blank(SPLATS, 2)


def _vm_density(rng: np.random.Generator) -> Arguments:
    points = _between(rng, 0, 15, 64, 3)
    points[0] = 15, 15, 15
    return points, _floats(rng, 16, 16, 16), _floats(rng, 16, 16), _blank(64)


GAUSSIANS: dict[str, Maker] = {
    "project_means": _project_means,
    "covariance_3d": _covariance_3d,
    "covariance_2d": _covariance_2d,
    "conic_and_radius": lambda r: (
        screen_covariances(some(r)),
        _blank(SPLATS, 3),
        _blank(SPLATS),
    ),
    "sh_colour": _sh_colour,
    "tile_bounds": _tile_bounds,
    "tile_entries": _tile_entries,
    "radix_histogram": lambda r: (_depth_bits(r), np.int32(16), _zeros(16)),
    "radix_offsets": lambda r: (r.integers(0, 99, 16, dtype=np.int32),),
    "radix_scatter": _radix_scatter,
    "tile_ranges": lambda r: (
        np.sort(r.integers(0, 169, 300)).astype(np.uint32),
        _zeros(169, 2),
    ),
}

RAYS: dict[str, Maker] = {
    "pixel_rays": lambda _: (
        mic_camera().c2w[:3, :3].copy(),
        np.array([100, 100], np.float32),
        np.float32(1 / mic_camera().focal),
        np.int32(77),
        np.int32(64),
        _blank(64, 3),
    ),
    "ray_box": _ray_box,
    "march_occupancy": _march_occupancy,
    "volume_blend": lambda r: (
        _between(r, 0, 8, 128),
        _between(r, 0, 1, 128, 3),
        np.float32(0.05),
        _blank(4),
    ),
}

ENCODINGS: dict[str, Maker] = {
    "positional_encoding": lambda r: (_between(r, -1.5, 1.5, 16, 3), np.int32(10), _blank(16, 63)),
    "hash_level": lambda r: (
        _between(r, 0, 1, 32, 3),
        np.float32(63.0),
        np.uint32(2047),
        _floats(r, 2048, 2),
        _blank(32, 2),
    ),
    "dense_level": lambda r: (
        _between(r, 0, 1, 32, 3),
        np.float32(11.0),
        np.int32(13),
        _floats(r, 13**3, 2),
        _blank(32, 2),
    ),
    "sh_direction": lambda r: (_directions(r, 64), _blank(64, 16)),
    "vm_density": _vm_density,
}

NETWORKS: dict[str, Maker] = {
    "dense_relu": lambda r: (
        _floats(r, 8, 63),
        _floats(r, 32, 63),
        _floats(r, 32),
        _blank(8, 32),
    ),
    "sigmoid": lambda r: (_between(r, -12, 12, 128),),
    "softplus": lambda r: (_between(r, -20, 40, 128), np.float32(-10.0), _blank(128)),
    "exponential_density": lambda r: (_floats(r, 64, 16), np.float32(15.0), _blank(64)),
}

FAMILIES = {
    "gaussians": GAUSSIANS,
    "rays": RAYS,
    "encodings": ENCODINGS,
    "networks": NETWORKS,
}

WORKLOADS = tuple(
    Workload(name, maker, f"render/{family}")
    for family, makers in FAMILIES.items()
    for name, maker in makers.items()
)
