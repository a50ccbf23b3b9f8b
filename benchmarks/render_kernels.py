"""The stages of the four renderers in `kernels/render/`, on Gaussians of `mic` or seeded data."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from benchmarks.workloads import KERNELS, Arguments, Workload
from vividc.render import Camera, Gaussians, Projection, load_cameras, project, read_gaussians

Maker = Callable[[np.random.Generator], Arguments]

COUNT = 48
PIXELS = 200
COLUMNS = 13


def _floats(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.standard_normal(shape).astype(np.float32)


def _unit(rng: np.random.Generator, n: int) -> np.ndarray:
    directions = _floats(rng, n, 3)
    return np.asarray(directions / np.linalg.norm(directions, axis=1)[:, None], np.float32)


def _places(rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(0, 1, (n, 3)).astype(np.float32)


@functools.cache
def scene() -> tuple[Gaussians, Camera, Projection]:
    """`COUNT` Gaussians of `scenes/mic` spread over the file, a camera, and their projection."""
    folder = KERNELS.parent / "scenes" / "mic"
    whole = read_gaussians(folder / "mic_3dgs_sh3.ply")
    rows = np.arange(0, len(whole), len(whole) // COUNT)[:COUNT]
    chosen = Gaussians(
        whole.means[rows],
        whole.scales[rows],
        whole.rotations[rows],
        whole.opacity[rows],
        whole.sh[rows],
    )
    camera = load_cameras(folder / "ref_gs.npz")[0]
    return chosen, camera, project(chosen, camera)


def view_arguments() -> tuple[np.ndarray, np.float32, np.float32, np.float32]:
    """[3, 4] world to camera, focal length and the two image centres, as `project_means` wants."""
    _, camera, _ = scene()
    view = np.ascontiguousarray(camera.world_to_view, np.float32)
    centres = (np.float32((size - 1) / 2) for size in (camera.width, camera.height))
    return view, np.float32(camera.focal), *centres


def limit() -> np.float32:
    """Clamp of x/z: 1.3 times the tangent of half the field of view."""
    _, camera, _ = scene()
    return np.float32(1.3 * camera.width / (2 * camera.focal))


def covariances(rng: np.random.Generator) -> np.ndarray:
    """[COUNT, 3] positive definite xx, xy, yy in pixel^2."""
    xx, yy = rng.uniform(0.4, 9, (2, COUNT))
    xy = rng.uniform(-0.9, 0.9, COUNT) * np.sqrt(xx * yy)
    return np.stack([xx, xy, yy], axis=1).astype(np.float32)


def _blank(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.float32)


def _zeros(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.int32)


def _project_means(_: np.random.Generator) -> Arguments:
    return scene()[0].means.copy(), *view_arguments(), _blank(COUNT, 2), _blank(COUNT)


def _covariance_3d(_: np.random.Generator) -> Arguments:
    return scene()[0].scales.copy(), scene()[0].rotations.copy(), _blank(COUNT, 6)


def _covariance_2d(rng: np.random.Generator) -> Arguments:
    view, focal, *_ = view_arguments()
    roots = rng.uniform(-0.1, 0.1, (COUNT, 3, 3))
    full = np.einsum("nij,nkj->nik", roots, roots)
    upper = np.ascontiguousarray(full[:, *np.triu_indices(3)], np.float32)
    return scene()[0].means.copy(), upper, view, focal, limit(), _blank(COUNT, 3)


def _sh_colour(rng: np.random.Generator) -> Arguments:
    return _unit(rng, COUNT), scene()[0].sh.copy(), _blank(COUNT, 3)


def pixels_and_radii(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Centres in and around the image, and footprints in whole pixels, some of them empty."""
    pixel = rng.uniform(-20, PIXELS + 20, (COUNT, 2)).astype(np.float32)
    return pixel, rng.integers(0, 30, COUNT).astype(np.float32)


def _tile_bounds(rng: np.random.Generator) -> Arguments:
    columns = np.int32(COLUMNS)
    return *pixels_and_radii(rng), columns, columns, _zeros(COUNT, 4), _zeros(COUNT)


def _tile_entries(rng: np.random.Generator) -> Arguments:
    first = rng.integers(0, COLUMNS - 3, (COUNT, 2))
    bounds = np.concatenate([first, first + rng.integers(0, 3, (COUNT, 2))], 1).astype(np.int32)
    copies = np.prod(bounds[:, 2:] - bounds[:, :2], axis=1).astype(np.int32)
    total = int(copies.sum())
    depths = rng.uniform(2, 6, COUNT).astype(np.float32).view(np.uint32)
    tables = (np.zeros(total, np.uint32), np.zeros(total, np.uint32), _zeros(total))
    return bounds, copies, depths, np.int32(COLUMNS), *tables


def _keys(rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(2, 6, n).astype(np.float32).view(np.uint32)


def _radix_scatter(rng: np.random.Generator) -> Arguments:
    keys, shift = _keys(rng, 200), 20
    counts = np.bincount(keys >> np.uint32(shift) & np.uint32(15), minlength=16)
    offsets = (np.cumsum(counts) - counts).astype(np.int32)
    values = np.arange(200, dtype=np.int32)
    return keys, values, np.int32(shift), offsets, np.zeros(200, np.uint32), _zeros(200)


def _tile_ranges(rng: np.random.Generator) -> Arguments:
    return np.sort(rng.integers(0, 40, 200)).astype(np.uint32), _zeros(40, 2)


def _pixel_rays(_: np.random.Generator) -> Arguments:
    _, camera, _ = scene()
    pose = np.ascontiguousarray(camera.c2w[:3, :3], np.float32)
    centre = np.array([camera.width / 2, camera.height / 2], np.float32)
    inverse = np.float32(1 / camera.focal)
    return pose, centre, inverse, np.int32(77), np.int32(60), _blank(60, 3)


def _ray_box(rng: np.random.Generator) -> Arguments:
    box = np.array([[-1.3, -1.0, -0.8], [0.8, 1.1, 1.2]], np.float32)
    origins = np.asarray(4 * _unit(rng, COUNT), np.float32)
    aims = rng.uniform(-1, 1, (COUNT, 3)) - origins
    directions = np.asarray(aims / np.linalg.norm(aims, axis=1)[:, None], np.float32)
    return origins, directions, box, np.float32(2), np.float32(6), _blank(COUNT, 2)


def _march_occupancy(rng: np.random.Generator) -> Arguments:
    shape = np.array([12, 10, 11], np.int32)
    words = rng.integers(0, 1 << 32, -(-int(shape.prod()) // 32), dtype=np.uint32)
    origin = np.array([-1.0, 4.0, 5.0], np.float32)
    direction = np.array([0.9, 0.3, 0.316], np.float32)
    span = (np.float32(0.5), np.float32(14.0), np.float32(0.11))
    return origin, direction, *span, words, shape, _blank(100)


def _volume_blend(rng: np.random.Generator) -> Arguments:
    density = rng.exponential(20, 100).astype(np.float32)
    return density, rng.uniform(0, 1, (100, 3)).astype(np.float32), np.float32(0.0124), _blank(4)


def _positional_encoding(rng: np.random.Generator) -> Arguments:
    return rng.uniform(-1, 1, (6, 3)).astype(np.float32), np.int32(10), _blank(6, 63)


def _hash_level(rng: np.random.Generator) -> Arguments:
    scale, mask = np.float32(117.3), np.uint32(1023)
    return _places(rng, COUNT), scale, mask, _floats(rng, 1024, 2), _blank(COUNT, 2)


def _dense_level(rng: np.random.Generator) -> Arguments:
    scale, resolution = np.float32(9.4), np.int32(11)
    return _places(rng, COUNT), scale, resolution, _floats(rng, 11**3, 2), _blank(COUNT, 2)


def _vm_density(rng: np.random.Generator) -> Arguments:
    points = (_places(rng, 24) * np.array([12, 14, 10], np.float32)).astype(np.float32)
    return points, _floats(rng, 16, 15, 13), _floats(rng, 16, 11), _blank(24)


def _dense_relu(rng: np.random.Generator) -> Arguments:
    return _floats(rng, 6, 32), _floats(rng, 16, 32), _floats(rng, 16), _blank(6, 16)


MAKERS: dict[str, dict[str, Maker]] = {
    "gaussians": {
        "project_means": _project_means,
        "covariance_3d": _covariance_3d,
        "covariance_2d": _covariance_2d,
        "conic_and_radius": lambda r: (covariances(r), _blank(COUNT, 3), _blank(COUNT)),
        "sh_colour": _sh_colour,
        "tile_bounds": _tile_bounds,
        "tile_entries": _tile_entries,
        "radix_histogram": lambda r: (_keys(r, 200), np.int32(20), _zeros(16)),
        "radix_offsets": lambda r: (r.integers(0, 30, 16, dtype=np.int32),),
        "radix_scatter": _radix_scatter,
        "tile_ranges": _tile_ranges,
    },
    "rays": {
        "pixel_rays": _pixel_rays,
        "ray_box": _ray_box,
        "march_occupancy": _march_occupancy,
        "volume_blend": _volume_blend,
    },
    "encodings": {
        "positional_encoding": _positional_encoding,
        "hash_level": _hash_level,
        "dense_level": _dense_level,
        "sh_direction": lambda r: (_unit(r, COUNT), _blank(COUNT, 16)),
        "vm_density": _vm_density,
    },
    "networks": {
        "dense_relu": _dense_relu,
        "sigmoid": lambda r: (np.asarray(4 * _floats(r, COUNT)),),
        "softplus": lambda r: (
            np.asarray(9 * _floats(r, COUNT)),
            np.float32(-10),
            _blank(COUNT),
        ),
        "exponential_density": lambda r: (
            np.asarray(6 * _floats(r, COUNT, 4)),
            np.float32(11),
            _blank(COUNT),
        ),
    },
}

WORKLOADS = tuple(
    Workload(name, maker, f"render/{file}")
    for file, makers in MAKERS.items()
    for name, maker in makers.items()
)
