"""Projection, tile binning and depth sort."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render import Camera, Gaussians, SceneError, TileLists, project, tile_lists
from vividc.render.arrays import frozen_float32

SIZE = 64
FOCAL = 80.0


def camera(width: int = SIZE, height: int = SIZE) -> Camera:
    """Return a camera at the origin that looks along -z."""
    return Camera(np.eye(4, dtype=np.float32), FOCAL, width, height)


def scene(means: list[tuple[float, float, float]], scale: float = 0.01) -> Gaussians:
    count = len(means)
    return Gaussians(
        means=frozen_float32(means),
        scales=frozen_float32(np.full((count, 3), scale)),
        rotations=frozen_float32([[1, 0, 0, 0]] * count),
        opacity=frozen_float32([0.5] * count),
        sh=frozen_float32(np.zeros((count, 1, 3))),
    )


def test_a_point_on_the_axis_lands_between_the_middle_pixels() -> None:
    splats = project(scene([(0, 0, -2)]), camera()).splats
    assert (splats.mean_x[0], splats.mean_y[0]) == ((SIZE - 1) / 2, (SIZE - 1) / 2)


def test_right_and_up_in_the_world_are_right_and_up_in_the_picture() -> None:
    splats = project(scene([(0.2, 0.1, -2)]), camera()).splats
    assert splats.mean_x[0] == pytest.approx((SIZE - 1) / 2 + FOCAL * 0.1, abs=1e-4)
    assert splats.mean_y[0] == pytest.approx((SIZE - 1) / 2 - FOCAL * 0.05, abs=1e-4)


def test_a_sphere_on_the_axis_has_a_round_footprint() -> None:
    scale, depth = 0.05, 2.0
    projection = project(scene([(0, 0, -depth)], scale), camera())
    variance = (FOCAL * scale / depth) ** 2 + 0.3
    assert projection.splats.conic_a[0] == pytest.approx(1 / variance, rel=1e-5)
    assert projection.splats.conic_c[0] == pytest.approx(1 / variance, rel=1e-5)
    assert projection.splats.conic_b[0] == pytest.approx(0, abs=1e-6)
    # The reference floors the eigenvalue spread at sqrt(0.1).
    assert projection.radius[0] == np.ceil(3 * np.sqrt(variance + np.sqrt(0.1)))


def double_conics(gaussians: Gaussians, cam: Camera) -> np.ndarray:
    """Return the conics [N, 3] by matrix products in float64, one Gaussian at a time."""
    view = np.linalg.inv(cam.c2w.astype(np.float64) @ np.diag([1.0, -1.0, -1.0, 1.0]))
    limit = 1.3 * np.array([cam.width, cam.height]) / (2 * cam.focal)
    conics = []
    for mean, scale, (w, *vector) in zip(
        gaussians.means, gaussians.scales, gaussians.rotations, strict=True
    ):
        x, y, z = (view @ np.append(mean.astype(np.float64), 1))[:3]
        x, y = np.clip([x / z, y / z], -limit, limit) * z
        axis = np.asarray(vector, dtype=np.float64)
        cross = np.cross(axis, np.eye(3)).T
        rotation = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        world = rotation @ np.diag(scale.astype(np.float64) ** 2) @ rotation.T
        f = cam.focal
        jacobian = np.array([[f / z, 0, -f * x / z**2], [0, f / z, -f * y / z**2]])
        to_screen = jacobian @ view[:3, :3]
        inverse = np.linalg.inv(to_screen @ world @ to_screen.T + 0.3 * np.eye(2))
        conics.append((inverse[0, 0], inverse[0, 1], inverse[1, 1]))
    return np.array(conics)


def test_conics_of_the_mic_agree_with_double_precision(
    mic: Gaussians, mic_cameras: tuple[Camera, ...]
) -> None:
    projection = project(mic, mic_cameras[0])
    chosen = slice(0, None, 101)
    rows = projection.index[chosen]
    subset = Gaussians(
        mic.means[rows], mic.scales[rows], mic.rotations[rows], mic.opacity[rows], mic.sh[rows]
    )
    s = projection.splats
    conics = np.stack((s.conic_a[chosen], s.conic_b[chosen], s.conic_c[chosen]), axis=1)
    # A needle's determinant cancels in float32: 1e-3 of the largest entry, 1e-5 is typical.
    expected = double_conics(subset, mic_cameras[0])
    error = np.abs(conics - expected).max(axis=1) / np.abs(expected).max(axis=1)
    assert error.max() < 1e-3
    assert np.median(error) < 1e-5


def test_the_slope_is_clamped_far_off_the_image() -> None:
    """x/z = 1.5 with a half field of view of 0.4: its large footprint still meets the image."""
    wide = scene([(3, 1, -2)], scale=1.5)
    s = project(wide, camera()).splats
    conic = (s.conic_a[0], s.conic_b[0], s.conic_c[0])
    np.testing.assert_allclose(conic, double_conics(wide, camera())[0], rtol=1e-4)


def test_everything_is_float32(mic_tiles: TileLists) -> None:
    assert {array.dtype for array in mic_tiles.splats.arrays().values()} == {np.dtype(np.float32)}


def test_culling_behind_the_near_plane_and_off_the_image() -> None:
    means = [(0, 0, -2), (0, 0, -0.2), (0, 0, 2), (5, 0, -2), (0, -5, -2)]
    assert project(scene(means), camera()).index.tolist() == [0]


def test_a_gaussian_too_large_for_float32_is_dropped_without_a_warning() -> None:
    with np.errstate(all="raise", under="ignore"):
        assert len(project(scene([(0, 0, -2)], scale=1e30), camera()).splats) == 0


def test_lists_are_sorted_by_depth_and_ties_keep_scene_order() -> None:
    tiles = tile_lists(scene([(0, 0, -3), (0, 0, -1), (0, 0, -2), (0, 0, -1)]), camera())
    for tile_y, tile_x in np.argwhere(tiles.lengths > 0):
        tile = tile_y * 4 + tile_x
        assert tiles.order[tiles.start[tile] : tiles.start[tile + 1]].tolist() == [1, 3, 2, 0]


def test_a_splat_is_in_exactly_the_tiles_its_square_meets() -> None:
    small = scene([(-0.2, 0.2, -1)], scale=0.001)
    projection = project(small, camera())
    x, y = projection.splats.mean_x[0], projection.splats.mean_y[0]
    radius = projection.radius[0]
    assert (x, y, radius) == (15.5, 15.5, 3)
    np.testing.assert_array_equal(
        tile_lists(small, camera()).lengths,
        [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]],
    )


def test_images_need_not_be_whole_tiles() -> None:
    tiles = tile_lists(scene([(0, 0, -2)]), camera(40, 20))
    assert tiles.lengths.shape == (2, 3)
    with pytest.raises(SceneError, match="outside the 3x2 tiles"):
        tiles.tile(3, 0)


def test_mic_lists_are_complete_and_sorted(mic_tiles: TileLists) -> None:
    assert mic_tiles.lengths.shape == (13, 13)
    assert int(mic_tiles.lengths.sum()) == len(mic_tiles.order)


def test_an_empty_scene_has_empty_lists() -> None:
    empty = Gaussians(
        *(frozen_float32(np.zeros(s)) for s in ((0, 3), (0, 3), (0, 4), (0,), (0, 1, 3)))
    )
    assert tile_lists(empty, camera()).lengths.sum() == 0
