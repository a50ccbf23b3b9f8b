"""The marching kernels, as numba runs them, against the float32 reference on random boxes."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render import Camera
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.march.bricks import pack_bricks
from vividc.render.array.march.depths import Blocks
from vividc.render.array.march.marching import geometry_of, parts_of
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


class Marched:
    """What the kernels make of a camera's first block: points and rays of the samples, by ray."""

    def __init__(self, march: March, camera: Camera, room: int = ROOM, at_once: int = 4) -> None:
        bricks, geometry = pack_bricks(march.occupied), geometry_of(march, camera)
        focal = camera.focal
        lens = np.array([camera.width, camera.height, focal, 1 / focal], np.float32)
        pose = np.ascontiguousarray(camera.c2w[:3, :3])
        corners, depths = np.zeros((1, 2), np.int32), np.array([[0, 3e38]], np.float32)
        rays = np.zeros((1, 64, 3), np.float32)
        entries, steps = np.zeros((1, 64), np.float32), np.zeros((1, 64), np.uint32)
        KERNELS.camera_rays(
            *(pose, lens, geometry, march.samples, corners, depths, rays, entries, steps)
        )
        self.directions = rays[0]
        tables = (geometry, bricks.grid, bricks.coarse, bricks.ranks, bricks.cells)
        (end,) = parts_of(march, Blocks(corners, depths), at_once)
        pieces, start = [], 0
        while True:
            items, count = np.zeros(room, np.int32), np.zeros(1, np.int32)
            work = np.zeros(64 * at_once, np.int32), np.zeros(64 * at_once, np.uint32)
            found = KERNELS.march_rays(
                *(rays[0], entries[0], steps[0], *tables, start, end, at_once, *work, items, count)
            )
            assert count[0] == found >> 16
            pieces.append(items[: count[0]])
            start = found & 0xFFFF
            if not start:
                break
        self.pieces = pieces
        self.items = np.concatenate(pieces)
        points = np.zeros((len(self.items), 3), np.float32)
        seen = np.zeros_like(points)
        KERNELS.sample_points(rays[0], entries[0], geometry, self.items, points)
        KERNELS.sample_directions(rays[0], self.items, seen)
        of_rays = self.items >> 16
        np.testing.assert_array_equal(seen, self.directions[of_rays])
        by_ray = np.argsort(of_rays, kind="stable")
        self.points, self.rays = points[by_ray], of_rays[by_ray]


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
    expected = occupied_samples(march, camera.position, pixel_rays(camera, 0, 64))
    marched = Marched(march, camera)
    points, rays = marched.points, marched.rays
    found = {(int(r), *np.round(p, 3)) for r, p in zip(rays, points, strict=True)}
    wanted = {(int(r), *np.round(p, 3)) for r, p in zip(expected.ray, expected.points, strict=True)}
    assert len(points) == pytest.approx(len(expected.points), abs=2)  # on the face of a cell
    assert len(found ^ wanted) <= 4 + 0.01 * len(wanted)  # rounded across a thousandth


@pytest.mark.parametrize("seed", range(4))
def test_samples_are_listed_by_step_and_then_by_ray(seed: int) -> None:
    march, camera = dense_march(seed), Camera(np.eye(4, dtype=np.float32), 20.0, 8, 8)
    items = Marched(march, camera).items
    steps, rays = items & 0xFFFF, items >> 16
    np.testing.assert_array_equal(np.lexsort((rays, steps)), np.arange(len(items)))


@pytest.mark.parametrize("room", [256, 300, 1000])
def test_where_there_is_no_room_the_next_launch_goes_on(room: int) -> None:
    march, camera = dense_march(7), Camera(np.eye(4, dtype=np.float32), 20.0, 8, 8)
    whole, cut = Marched(march, camera), Marched(march, camera, room)
    assert len(whole.items) > 2 * room
    assert len(cut.pieces) > 2
    assert all(0 < len(piece) <= room for piece in cut.pieces)
    np.testing.assert_array_equal(cut.items, whole.items)


def dense_march(seed: int) -> March:
    """A camera in the middle of a box of which half the cells are occupied."""
    box = np.array([[-1, -1, -1], [1, 1, 1]], np.float32)
    occupied = np.random.default_rng(seed).random((9, 6, 12)) < 0.5
    return March(box, 0.0, 9.0, 0.01, 150, occupied)


def test_rays_outside_the_picture_and_along_a_face() -> None:
    """The picture has two columns, and their rays are parallel to two faces."""
    box = np.array([[-1, -1, -1], [1, 1, 1]], np.float32)
    march = March(box, 0.0, 9.0, 0.25, 100, np.ones((4, 4, 4), np.bool_))
    camera = Camera(np.eye(4, dtype=np.float32), 1e9, 2, 1)
    marched = Marched(march, camera)
    assert list(marched.rays) == [0, 0, 0, 0, 1, 1, 1, 1]
    np.testing.assert_allclose(marched.points[0], (0, 0, -0.125), atol=1e-6)
    np.testing.assert_allclose(marched.points[-1], (0, 0, -0.875), atol=1e-6)
    assert not marched.directions[2:].any()


@pytest.mark.parametrize("exponent", [0, 1, 60, 115])
def test_inverses_are_those_of_a_division(exponent: int) -> None:
    """Of the number below a power of two the inverse lies all but half-way between two numbers."""
    rng = np.random.default_rng(exponent)
    mantissas = np.append(rng.integers(0, 1 << 23, 20_000), [0, 1, (1 << 23) - 2, (1 << 23) - 1])
    numbers = (mantissas + ((127 + exponent) << 23)).astype(np.uint32).view(np.float32)
    found = np.array([KERNELS.inverse(number) for number in numbers], np.float32)
    np.testing.assert_array_equal(found, np.float32(1) / numbers)
