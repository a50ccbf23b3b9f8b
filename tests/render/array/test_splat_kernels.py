"""The kernels of 3DGS under numba: projection, colour, culling and both ways of blending."""

from __future__ import annotations

import importlib.util
from functools import cache
from types import ModuleType

import numpy as np
import pytest

from vividc.render import (
    Camera,
    Crop,
    Gaussians,
    blend_block,
    over_background,
    project,
    scaled_camera,
)
from vividc.render.array.device.programs import kernel_folder
from vividc.render.array.splats.scene import camera_words, device_scene, screen_tiles
from vividc.render.splat.spherical_harmonics import sh_colour
from vividc.render.splat.splat import Splats

PART = 160
BESIDE = ("mean_x", "mean_y", "conic_a", "conic_b", "conic_c", "opacity")
"""Columns 0 to 5 of a row."""


@cache
def kernels(file: str) -> ModuleType:
    path = kernel_folder() / "render" / f"{file}.py"
    spec = importlib.util.spec_from_file_location(f"tested_{file}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def footprints(
    scene: Gaussians, camera: Camera, margin: float = 1e-5
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return rows [n, 13], entries [n, 3] and rows of the scene [n] of what is seen."""
    on_device = device_scene(scene)
    n = len(scene)
    placed = np.zeros((n, 6), np.float32)
    file = kernels("splat_project")
    file.splat_covariance(on_device.geometry, camera_words(camera), placed)
    rows, entries = np.zeros(13 * n, np.float32), np.zeros(3 * n, np.int32)
    sources, depths = np.zeros(n, np.int32), np.zeros(2, np.int32)
    columns, lines = screen_tiles(camera)
    seen = file.splat_footprints(
        *(placed, on_device.opacity, np.float32(margin), columns, lines, 0),
        *(rows, entries, sources, depths),
    )
    return rows.reshape(-1, 13)[:seen], entries.reshape(-1, 3)[:seen], sources[:seen]


def some(scene: Gaussians, count: int, seed: int = 0) -> Gaussians:
    chosen = np.sort(np.random.default_rng(seed).choice(len(scene), count, replace=False))
    return Gaussians(
        scene.means[chosen],
        scene.scales[chosen],
        scene.rotations[chosen],
        scene.opacity[chosen],
        scene.sh[chosen],
    )


def flat_scene(means: list[list[float]], scale: float = 0.05) -> Gaussians:
    """White Gaussians of one size, without colour that depends on the direction."""
    n = len(means)
    return Gaussians(
        np.array(means, np.float32).reshape(n, 3),
        np.full((n, 3), scale, np.float32),
        np.tile(np.array([1, 0, 0, 0], np.float32), (n, 1)),
        np.full(n, 0.5, np.float32),
        np.ones((n, 1, 3), np.float32),
    )


def ahead(size: int = 64) -> Camera:
    """Looks along -z from the origin."""
    return Camera(np.eye(4, dtype=np.float32), float(size), size, size)


def blended(kernel: str, rows: np.ndarray, block: Crop, part: int = PART) -> tuple:
    """Return pixels [16, 16, 4] over white and counts of one screen tile, part by part."""
    pixels = np.tile(np.array([0, 0, 0, 1], np.float32), 256)
    counts = np.zeros(4, np.int32)
    starts = range(0, len(rows), part)
    for start in starts:
        some_rows = np.ascontiguousarray(rows[start : start + part])
        getattr(kernels("splat_blend"), kernel)(
            *(some_rows.ravel(), pixels, counts, len(some_rows)),
            *(np.float32(block.x0), np.float32(block.y0), block.height, int(start == starts[-1])),
        )
    by_row = pixels.reshape(4, 4, 4, 4, 4).transpose(0, 2, 1, 3, 4)
    return by_row.reshape(16, 16, 4), counts


OPAQUE = (0.003, 0.005, 0.05, 0.4, 0.999)
FAINT = (0.003, 0.005, 0.01, 0.02, 0.05)


def random_rows(count: int, seed: int, peaks: tuple[float, ...] = OPAQUE) -> np.ndarray:
    """Rows of splats around a screen tile at (32, 16), long and thin, faint, and large."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, np.pi, count)
    sizes = np.exp(rng.uniform(-0.6, 4, (count, 2)))
    turn = np.stack((np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)), 1)
    turn = turn.reshape(count, 2, 2)
    covariance = turn @ (sizes[:, :, None] ** 2 * turn.transpose(0, 2, 1))
    covariance[:, 0, 0] += 0.3
    covariance[:, 1, 1] += 0.3
    placed = np.zeros((count, 6), np.float32)
    placed[:, 0] = 40 + rng.normal(0, 12, count)
    placed[:, 1] = 24 + rng.normal(0, 12, count)
    placed[:, 2] = 1
    placed[:, 3:] = covariance.reshape(count, 4)[:, [0, 1, 3]]
    opacity = rng.choice(peaks, (count, 1)).astype(np.float32)
    rows = np.zeros(13 * count, np.float32)
    others = np.zeros(3 * count, np.int32), np.zeros(count, np.int32), np.zeros(2, np.int32)
    seen = kernels("splat_project").splat_footprints(
        placed, opacity, np.float32(1e-5), 200, 200, 0, rows, *others
    )
    rows = rows.reshape(-1, 13)[:seen]
    rows[:, 7:10] = rng.random((seen, 3))
    return np.ascontiguousarray(rows)


def as_splats(rows: np.ndarray) -> Splats:
    return Splats(*(rows[:, k].copy() for k in (*range(6), 7, 8, 9)))


@pytest.mark.parametrize("view", [0, 1])
def test_footprints_are_those_of_the_reference(
    mic: Gaussians, mic_cameras: tuple, view: int
) -> None:
    camera = scaled_camera(mic_cameras[view], 120, 120)
    scene = some(mic, 1000)
    reference = project(scene, camera)
    rows, entries, sources = footprints(scene, camera)
    np.testing.assert_array_equal(sources, reference.index)
    for column, name in enumerate(BESIDE):
        expected = getattr(reference.splats, name)
        np.testing.assert_allclose(rows[:, column], expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(entries[:, 2].view(np.float32), reference.depth, rtol=1e-6)
    assert (entries[:, 1] == np.arange(len(entries))).all()


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_colours_of_every_degree(mic: Gaussians, mic_cameras: tuple, degree: int) -> None:
    scene = some(mic, 200, degree)
    cut = scene.sh[:, : (degree + 1) ** 2].copy()
    scene = Gaussians(scene.means, scene.scales, scene.rotations, scene.opacity, cut)
    eye = mic_cameras[0].position
    rows = np.zeros((200, 13), np.float32)
    kernel = getattr(kernels("splat_project"), f"splat_colours_{degree}")
    kernel(device_scene(scene).appearance, *eye, rows)
    offset = scene.means - eye
    directions = offset / np.linalg.norm(offset, axis=1, keepdims=True)
    np.testing.assert_allclose(rows[:, 7:10], sh_colour(cut, directions), atol=2e-6)


def test_what_cannot_be_seen_gets_no_footprint() -> None:
    behind, near, beside, here = [0, 0, 3], [0, 0, -0.1], [50, 0, -3], [0, 0, -3]
    _, entries, sources = footprints(flat_scene([behind, near, beside, here]), ahead())
    assert sources.tolist() == [3]
    assert entries[0, 0].item().to_bytes(4, "little") == bytes([1, 3, 1, 3])


@pytest.mark.parametrize("scale", [0.0, 1e-30, 1e18, 3e38])
def test_degenerate_covariances_are_those_of_the_reference(scale: float) -> None:
    scene = flat_scene([[0, 0, -3], [0.5, 0.2, -4]], scale)
    reference = project(scene, ahead())
    rows, _, sources = footprints(scene, ahead())
    np.testing.assert_array_equal(sources, reference.index)
    np.testing.assert_allclose(rows[:, 2], reference.splats.conic_a, rtol=1e-5)


@pytest.mark.parametrize("peaks", [OPAQUE, FAINT], ids=["opaque", "faint"])
@pytest.mark.parametrize("seed", range(4))
def test_lookahead_gives_the_picture_of_the_late_test(seed: int, peaks: tuple[float, ...]) -> None:
    rows = random_rows(500, seed, peaks)
    block = Crop(32, 16, 16, 16)
    late, every = blended("blend_late", rows, block)
    coarse, some_of_them = blended("blend_blocks", rows, block)
    early, fewer = blended("blend_lookahead", rows, block)
    np.testing.assert_array_equal(coarse, late)
    np.testing.assert_array_equal(early, late)
    assert fewer[0] == some_of_them[0] == 16 * len(rows)
    assert 0 < fewer[2] < fewer[1] == some_of_them[1] < every[1]
    whole = over_background(blend_block(as_splats(rows), block).rgbt)
    np.testing.assert_allclose(late[..., :3], whole, atol=2e-5)


@pytest.mark.parametrize("kernel", ["blend_late", "blend_blocks", "blend_lookahead"])
@pytest.mark.parametrize("part", [1, 47, 100])
def test_a_list_in_parts_gives_the_same_picture(kernel: str, part: int) -> None:
    rows = random_rows(300, 9)
    block = Crop(32, 16, 16, 16)
    whole, _ = blended(kernel, rows, block)
    pixels, _ = blended(kernel, rows, block, part)
    np.testing.assert_array_equal(pixels, whole)


def test_rows_below_the_image_are_left_alone() -> None:
    rows = random_rows(50, 3)
    whole, _ = blended("blend_lookahead", rows, Crop(32, 16, 16, 16))
    cut, _ = blended("blend_lookahead", rows, Crop(32, 16, 16, 5))
    np.testing.assert_array_equal(cut[:5], whole[:5])
    np.testing.assert_array_equal(cut[8:], np.ones((8, 16, 4)))


def test_culling_keeps_all_that_counts() -> None:
    file = kernels("splat_blend")
    for seed in range(20):
        rows = random_rows(PART, seed)
        kept = np.zeros(PART, np.int32)
        x, y = np.float32(32 + 4 * (seed % 4)), np.float32(16 + 4 * (seed // 5))
        count = file.cull(rows.ravel(), len(rows), x, y, kept)
        block = Crop(int(x), int(y), 4, 4)
        seen = {
            k
            for k in range(len(rows))
            if blend_block(as_splats(rows[k : k + 1]), block).blended.any()
        }
        assert seen <= set((kept[:count] // 13).tolist())
        assert count < len(rows)
