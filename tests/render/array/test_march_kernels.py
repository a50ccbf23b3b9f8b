"""The marching kernels, as numba runs them, against the float32 reference on random boxes."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render import Camera
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.march.bricks import pack_bricks
from vividc.render.array.march.marching import geometry_of
from vividc.render.radiance import March, pixel_rays
from vividc.render.radiance.occupancy import occupied_samples

KERNELS = kernel_module(kernel_folder() / "render" / "marching.py")
ROOM = 4000


def random_camera(rng: np.random.Generator, distance: float) -> Camera:
    """Somewhere at a distance of the origin, looking anywhere near it."""
    rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    pose = np.eye(4, dtype=np.float32)
    pose[:3, :3] = rotation
    pose[:3, 3] = distance * rotation[:, 2]
    return Camera(pose, 9.0, 8, 8)


def marched(march: March, camera: Camera, directions: np.ndarray, base: int) -> tuple:
    bricks = pack_bricks(march.occupied)
    count = len(directions)
    geometry = geometry_of(march, camera)
    entries, exits = np.zeros(count, np.float32), np.zeros(count, np.float32)
    steps, candidates = np.zeros(count, np.int32), np.zeros(ROOM, np.int32)
    items = np.zeros(ROOM, np.int32)
    tables = (bricks.grid, bricks.coarse, bricks.ranks, bricks.cells)
    found = KERNELS.march_rays(
        directions,
        geometry,
        *tables,
        *(march.samples, base, entries, exits, steps, candidates, items),
    )
    points, rays = np.zeros((found, 3), np.float32), np.zeros(found, np.int32)
    at = np.zeros(base + count, np.float32)
    at[base:] = entries
    whole = np.zeros((base + count, 3), np.float32)
    whole[base:] = directions
    KERNELS.sample_points(whole, at, geometry, items[:found], 100, points, rays)
    return points, rays - 100 - base


@pytest.mark.parametrize("seed", range(12))
def test_samples_are_the_references(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.uniform(-2, -0.5, 3)
    box = np.array([low, low + rng.uniform(1, 3, 3)], np.float32)
    shape = tuple(rng.integers(1, 20, 3))
    near, far = rng.uniform(0, 1.5), rng.uniform(2, 8)
    occupied = rng.random(shape) < rng.choice([0.05, 0.5, 1.0])
    march = March(box, near, far, float(rng.uniform(0.03, 0.2)), 60, occupied)
    camera = random_camera(rng, float(rng.choice([0.1, 2.0, 4.0])))
    directions = pixel_rays(camera, 0, 64)
    expected = occupied_samples(march, camera.position, directions)
    points, rays = marched(march, camera, directions, int(rng.integers(0, 3)))
    found = {(int(r), *np.round(p, 3)) for r, p in zip(rays, points, strict=True)}
    wanted = {(int(r), *np.round(p, 3)) for r, p in zip(expected.ray, expected.points, strict=True)}
    assert len(points) == pytest.approx(len(expected.points), abs=2)  # on the face of a cell
    assert len(found ^ wanted) <= 4 + 0.01 * len(wanted)  # rounded across a thousandth


def test_rays_outside_the_picture_and_along_a_face() -> None:
    box = np.array([[-1, -1, -1], [1, 1, 1]], np.float32)
    march = March(box, 0.0, 9.0, 0.25, 100, np.ones((4, 4, 4), np.bool_))
    camera = Camera(np.eye(4, dtype=np.float32), 8.0, 8, 8)
    directions = np.array([[0, 0, 0], [0, 0, -1], [1, 0, 0]], np.float32)
    points, rays = marched(march, camera, directions, 0)
    assert list(rays) == [1, 1, 1, 1, 2, 2, 2, 2]
    np.testing.assert_allclose(points[0], (0, 0, -0.125))
    np.testing.assert_allclose(points[-1], (0.875, 0, 0))


def test_more_samples_than_room_are_told() -> None:
    box = np.array([[-1, -1, -1], [1, 1, 1]], np.float32)
    march = March(box, 0.0, 9.0, 0.002, 600, np.ones((4, 4, 4), np.bool_))
    camera = Camera(np.eye(4, dtype=np.float32), 8.0, 8, 8)
    bricks = pack_bricks(march.occupied)
    directions = np.tile(np.array([[0, 0, -1]], np.float32), (9, 1))
    floats, words = np.zeros((2, 9), np.float32), np.zeros((2, ROOM), np.int32)
    tables = (bricks.grid, bricks.coarse, bricks.ranks, bricks.cells)
    found = KERNELS.march_rays(
        directions,
        geometry_of(march, camera),
        *tables,
        *(march.samples, 0, *floats, np.zeros(9, np.int32), *words),
    )
    assert found > ROOM
    assert not words[1].any()
