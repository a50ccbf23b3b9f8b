"""Cameras, and reading them from files of reference views."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc.render import (
    Camera,
    SceneError,
    load_cameras,
    load_reference_images,
    project,
    scaled_camera,
)
from vividc.render.ply import Gaussians

IDENTITY = np.eye(4, dtype=np.float32)


def test_mic_views(mic_views: Path) -> None:
    cameras = load_cameras(mic_views)
    assert [(c.width, c.height) for c in cameras] == [(200, 200)] * 2
    assert cameras[0].focal == pytest.approx(277.7778, rel=1e-6)
    assert load_reference_images(mic_views).shape == (2, 200, 200, 3)


def test_world_to_view_turns_opengl_axes_into_opencv_axes(
    mic_cameras: tuple[Camera, ...],
) -> None:
    for camera in mic_cameras:
        flip = np.diag([1.0, -1.0, -1.0, 1.0])
        expected = np.linalg.inv(camera.c2w.astype(np.float64) @ flip)[:3]
        np.testing.assert_allclose(camera.world_to_view, expected, atol=2e-6)
        assert camera.world_to_view.dtype == np.float32


def test_scaling_keeps_the_field_of_view(mic: Gaussians, mic_cameras: tuple[Camera, ...]) -> None:
    small = mic_cameras[0]
    large = scaled_camera(small, 400, 400)
    assert large.focal == pytest.approx(2 * small.focal)
    at_small, at_large = project(mic, small), project(mic, large)
    common, rows_small, rows_large = np.intersect1d(
        at_small.index, at_large.index, return_indices=True
    )
    assert len(common) > len(mic) // 2
    # Pixel centres are at integers, so picture coordinates are (x + 0.5) / width.
    np.testing.assert_allclose(
        (at_large.splats.mean_x[rows_large] + 0.5) / 400,
        (at_small.splats.mean_x[rows_small] + 0.5) / 200,
        atol=1e-6,
    )


def test_scaling_refuses_another_aspect_ratio() -> None:
    with pytest.raises(SceneError, match="aspect ratio"):
        scaled_camera(Camera(IDENTITY, 100.0, 40, 30), 40, 40)


@pytest.mark.parametrize(
    ("focal", "width", "height"),
    [(0.0, 8, 8), (float("nan"), 8, 8), (100.0, 0, 8), (100.0, 8, -1)],
)
def test_impossible_cameras(focal: float, width: int, height: int) -> None:
    with pytest.raises(SceneError, match="impossible camera"):
        Camera(IDENTITY, focal, width, height)


def test_pose_must_be_a_finite_matrix() -> None:
    with pytest.raises(SceneError, match="4x4"):
        Camera(IDENTITY[:3], 100.0, 8, 8)
    with pytest.raises(SceneError, match="4x4"):
        Camera(IDENTITY * np.float32(np.nan), 100.0, 8, 8)


def test_missing_file_of_views(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read"):
        load_cameras(tmp_path / "absent.npz")


@pytest.mark.parametrize("content", [b"", b"not an npz", b"PK\x03\x04 broken"])
def test_damaged_file_of_views(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "views.npz"
    path.write_bytes(content)
    with pytest.raises(SceneError, match="not a usable npz"):
        load_cameras(path)


def test_npy_is_not_a_file_of_views(tmp_path: Path) -> None:
    path = tmp_path / "views.npy"
    np.save(path, IDENTITY)
    with pytest.raises(SceneError, match="an npy file"):
        load_cameras(path)


def test_missing_and_misshapen_arrays(tmp_path: Path) -> None:
    path = tmp_path / "views.npz"
    np.savez(path, c2w=IDENTITY[None], focal=1.0)
    with pytest.raises(SceneError, match=r"lacks an array: .*size"):
        load_cameras(path)
    np.savez(path, c2w=IDENTITY, focal=1.0, size=8)
    with pytest.raises(SceneError, match="unexpected shapes"):
        load_cameras(path)
