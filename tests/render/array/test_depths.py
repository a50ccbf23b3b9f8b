"""Blocks that see no brick, and steps that are left out, have no sample: on random cameras and
boxes, the kernels as numba runs them.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.array.by_numba import Host
from vividc.render import Camera
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.march import depths
from vividc.render.array.march.bricks import pack_bricks
from vividc.render.array.march.depths import Blocks, block_corners, seen_blocks
from vividc.render.array.march.marching import geometry_of, parts_of
from vividc.render.radiance import March

KERNELS = kernel_module(kernel_folder() / "render" / "marching.py")
AT_ONCE = 4
ROOM = 20_000


def random_march(rng: np.random.Generator, *, cells: int = 24) -> March:
    """A box that is no cube, cells that are none, and few or many of them set."""
    low = rng.uniform(-2, -0.5, 3) * rng.choice([0.01, 1.0, 30.0])
    box = np.array([low, low + np.abs(low) * rng.uniform(0.3, 4, 3)], np.float32)
    shape = tuple(rng.integers(1, cells, 3))
    occupied = rng.random(shape) < rng.choice([0.002, 0.02, 0.3])
    occupied[tuple(rng.integers(0, shape))] = True
    extent = float(np.linalg.norm(box[1] - box[0]))
    near = float(rng.choice([0.0, 0.3, 1.2])) * extent
    step = extent / float(rng.uniform(20, 300))
    return March(box, near, near + 3 * extent, step, int(rng.integers(40, 400)), occupied)


def random_camera(rng: np.random.Generator, march: March) -> Camera:
    """In the box, at one of its faces, or far away; looking anywhere, or along an axis."""
    rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    if rng.random() < 0.2:
        rotation = np.eye(3)[rng.permutation(3)] * rng.choice([-1, 1], 3)
    middle, extent = march.box.mean(axis=0), march.box[1] - march.box[0]
    pose = np.eye(4, dtype=np.float32)
    pose[:3, :3] = rotation
    if rng.random() < 0.4:
        pose[:3, 3] = middle + extent * rng.uniform(-0.5, 0.5, 3)
        if rng.random() < 0.3:
            axis = rng.integers(3)
            pose[axis, 3] = march.box[rng.integers(2), axis]
    else:
        away = rng.uniform(0.6, 4) * np.linalg.norm(extent)
        aside = rng.standard_normal(3) * extent * rng.choice([0.0, 0.5])
        pose[:3, 3] = middle + aside + away * rotation[:, 2]
    width, height = (int(side) for side in rng.integers(1, 60, 2))
    return Camera(pose, float(rng.uniform(0.3, 4)) * max(width, height), width, height)


def samples(march: March, camera: Camera, blocks: Blocks) -> dict[tuple[int, ...], list[int]]:
    """The samples of each block that has any, in the order in which the kernel lists them."""
    bricks, geometry = pack_bricks(march.occupied), geometry_of(march, camera)
    focal = camera.focal
    lens = np.array([camera.width, camera.height, focal, 1 / focal], np.float32)
    shape = (len(blocks), 64)
    directions = np.zeros((*shape, 3), np.float32)
    entries, steps = np.zeros(shape, np.float32), np.zeros(shape, np.uint32)
    pose = np.ascontiguousarray(camera.c2w[:3, :3])
    KERNELS.camera_rays(
        *(pose, lens, geometry, march.samples, blocks.corners, blocks.depths),
        *(directions, entries, steps),
    )
    tables = (geometry, bricks.grid, bricks.coarse, bricks.ranks, bricks.cells)
    found = {}
    candidates, bricks_of = np.zeros(64 * AT_ONCE, np.int32), np.zeros(64 * AT_ONCE, np.uint32)
    ends = parts_of(march, blocks, AT_ONCE)
    for number, (corner, end) in enumerate(zip(blocks.corners, ends, strict=True)):
        items, count = np.zeros(ROOM, np.int32), np.zeros(1, np.int32)
        rays = (directions[number], entries[number], steps[number])
        room = (candidates, bricks_of, items, count)
        kept = KERNELS.march_rays(*rays, *tables, 0, end, AT_ONCE, *room)
        assert kept & 0xFFFF == 0
        assert count[0] == kept >> 16
        if kept:
            found[tuple(map(int, corner))] = items[: kept >> 16].tolist()
    return found


def everywhere(corners: np.ndarray) -> Blocks:
    return Blocks(corners, np.tile(np.array([0, 3e38], np.float32), (len(corners), 1)))


@pytest.fixture
def host() -> Host:
    return Host()


@pytest.mark.parametrize("seed", range(40))
def test_no_sample_is_lost(seed: int, host: Host) -> None:
    rng = np.random.default_rng(seed)
    march = random_march(rng)
    camera = random_camera(rng, march)
    corners = block_corners(camera)
    blocks = seen_blocks(host, march, camera, corners)
    expected = samples(march, camera, everywhere(corners))
    found = samples(march, camera, blocks)
    assert {place: sorted(items) for place, items in found.items()} == {
        place: sorted(items) for place, items in expected.items()
    }
    assert host.ledger.stages[depths.STAGE].whole
