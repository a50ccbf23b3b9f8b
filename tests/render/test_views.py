"""Cameras and pictures of `transforms.json` and npz files, and what is said of broken ones."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vividc.render import SceneError, read_views

POSE = np.eye(4)
RGBA = np.arange(4 * 6 * 4, dtype=np.uint8).reshape(4, 6, 4)


def transforms(folder: Path, **changes: object) -> Path:
    document = {
        "camera_angle_x": 0.7,
        "frames": [{"file_path": "./test/r_0", "transform_matrix": POSE.tolist()}],
    } | changes
    path = folder / "transforms.json"
    path.write_text(
        json.dumps({key: value for key, value in document.items() if value is not None})
    )
    return path


def with_picture(folder: Path) -> None:
    (folder / "test").mkdir()
    Image.fromarray(RGBA).save(folder / "test" / "r_0.png")


def test_blender_transforms_with_a_picture(tmp_path: Path) -> None:
    with_picture(tmp_path)
    (view,) = read_views(transforms(tmp_path))
    assert (view.camera.width, view.camera.height, view.name) == (6, 4, "./test/r_0")
    assert view.camera.focal == pytest.approx(3 / math.tan(0.35))
    np.testing.assert_array_equal(view.camera.c2w, POSE)
    colour, alpha = RGBA[..., :3] / 255, RGBA[..., 3:] / 255
    np.testing.assert_allclose(view.truth(), colour * alpha + 1 - alpha, atol=1e-6)


def test_a_smaller_truth_is_the_mean_of_squares(tmp_path: Path) -> None:
    with_picture(tmp_path)
    (view,) = read_views(transforms(tmp_path))
    whole, half = view.truth(), view.truth_at(3, 2)
    assert whole is not None
    assert half is not None
    np.testing.assert_allclose(half[1, 2], whole[2:4, 4:6].mean(axis=(0, 1)), rtol=1e-6)
    assert view.truth_at(12, 8) is None
    assert view.truth_at(4, 3) is None
    assert view.camera_at(3, 2).focal == pytest.approx(view.camera.focal / 2)


def test_blender_transforms_without_pictures(tmp_path: Path) -> None:
    (view,) = read_views(transforms(tmp_path))
    assert (view.camera.width, view.camera.height) == (800, 800)
    assert view.truth() is None
    (sized,) = read_views(transforms(tmp_path, w=64, h=48, fl_x=50))
    assert (sized.camera.width, sized.camera.height, sized.camera.focal) == (64, 48, 50)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"frames": 3}, "`frames` is not a list"),
        ({"frames": [3]}, "`frames` is not a list of objects"),
        ({"frames": []}, "holds no view"),
        ({"frames": [{"file_path": "a"}]}, "frames[0].transform_matrix is not a finite 4x4"),
        ({"frames": [{"transform_matrix": [[1, 2], [3]]}]}, "frames[0].transform_matrix"),
        ({"frames": [{"transform_matrix": [["x"] * 4] * 4}]}, "frames[0].transform_matrix"),
        ({"camera_angle_x": None}, "`camera_angle_x` is not a number"),
        ({"camera_angle_x": "wide"}, "`camera_angle_x` is not a number"),
        ({"camera_angle_x": 0}, "`camera_angle_x` is 0, not positive"),
        ({"camera_angle_x": 4}, "camera_angle_x is 4, not below pi"),
        ({"w": 10}, "`h` is not a number"),
    ],
)
def test_broken_transforms(tmp_path: Path, changes: dict[str, object], text: str) -> None:
    with pytest.raises(SceneError) as raised:
        read_views(transforms(tmp_path, **changes))
    assert text in str(raised.value)
    assert str(tmp_path) in str(raised.value)


def test_files_that_are_no_json_or_no_picture(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read: No such file"):
        read_views(tmp_path / "absent.json")
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    with pytest.raises(SceneError, match="not JSON"):
        read_views(broken)
    broken.write_text("[]")
    with pytest.raises(SceneError, match="not an object"):
        read_views(broken)
    with_picture(tmp_path)
    (tmp_path / "test" / "r_0.png").write_bytes(b"no picture")
    with pytest.raises(SceneError, match="not a picture"):
        read_views(transforms(tmp_path))


def test_pictures_of_different_sizes(tmp_path: Path) -> None:
    with_picture(tmp_path)
    (view,) = read_views(transforms(tmp_path, w=5, h=4))
    with pytest.raises(SceneError, match="has 6x4 pixels, its camera 5x4"):
        view.truth()


def archive(folder: Path, **changes: object) -> Path:
    arrays = {"test_poses": POSE[None], "test_images": RGBA[None], "focal": np.float32(7)} | changes
    np.savez(
        folder / "views.npz", **{key: value for key, value in arrays.items() if value is not None}
    )
    return folder / "views.npz"


def test_npz_of_photographs_and_of_renders(tmp_path: Path, mic_views: Path) -> None:
    (view,) = read_views(archive(tmp_path))
    assert (view.camera.width, view.camera.height, view.camera.focal) == (6, 4, 7)
    truth = view.truth()
    assert truth is not None
    assert truth[0, 0, 0] == pytest.approx(1 - 3 / 255)
    first, second = read_views(mic_views)
    assert (first.name, second.name) == ("0", "1")
    assert first.camera.width == 200
    assert first.truth().shape == (200, 200, 3)


def test_npz_without_pictures(tmp_path: Path) -> None:
    np.savez(tmp_path / "views.npz", c2w=POSE[None], focal=7.0, size=9)
    (view,) = read_views(tmp_path / "views.npz")
    assert (view.camera.width, view.truth()) == (9, None)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"test_poses": None}, "neither `c2w` nor `test_poses`"),
        ({"focal": None}, "`focal` is missing"),
        ({"focal": -1.0}, "focal is -1, not above 0"),
        ({"test_images": None}, "`size` is missing"),
        ({"test_images": RGBA[None, ..., 0]}, "not pictures of the 1 poses"),
        ({"test_images": np.stack((RGBA, RGBA))}, "not pictures of the 1 poses"),
        ({"test_poses": POSE}, "has shape [4, 4], not [any, 4, 4]"),
        ({"test_poses": POSE[None] * np.nan}, "is nan, not a finite float32"),
        ({"test_poses": np.array([[["x"] * 4] * 4])}, "holds <U1, not numbers"),
    ],
)
def test_broken_npz(tmp_path: Path, changes: dict[str, object], text: str) -> None:
    with pytest.raises(SceneError) as raised:
        read_views(archive(tmp_path, **changes))
    assert text in str(raised.value)
    assert "views.npz" in str(raised.value)
