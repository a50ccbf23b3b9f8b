"""PNG files and comparison sheets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vividc.render import SceneError, side_by_side, to_uint8, upscale_nearest, write_png


def gradient(width: int, height: int) -> np.ndarray:
    values = np.linspace(0, 1, width * height * 3, dtype=np.float32)
    return values.reshape(height, width, 3)


def test_to_uint8_rounds_and_clips() -> None:
    image = np.array([[[-0.5, 0.0, 0.5], [1.0, 1.5, 254.4 / 255]]], dtype=np.float32)
    np.testing.assert_array_equal(to_uint8(image), [[[0, 0, 128], [255, 255, 254]]])


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_png_round_trip(tmp_path: Path, dtype: type) -> None:
    image = gradient(5, 4) if dtype is np.float32 else to_uint8(gradient(5, 4))
    write_png(tmp_path / "picture.png", image)
    np.testing.assert_array_equal(
        np.asarray(Image.open(tmp_path / "picture.png")), to_uint8(gradient(5, 4))
    )


def test_png_into_a_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be written"):
        write_png(tmp_path / "absent" / "picture.png", gradient(2, 2))


def test_unwritten_pixels_are_refused() -> None:
    with pytest.raises(SceneError, match="nan"):
        to_uint8(np.full((2, 2, 3), np.nan, dtype=np.float32))
    with pytest.raises(SceneError, match="shape"):
        to_uint8(np.zeros((2, 2), dtype=np.float32))


def test_upscaling_repeats_pixels() -> None:
    image = gradient(3, 2)
    large = upscale_nearest(image, 4)
    assert large.shape == (8, 12, 3)
    np.testing.assert_array_equal(large[3::4, 3::4], image)
    with pytest.raises(SceneError, match="upscale"):
        upscale_nearest(image, 0)


def test_side_by_side_shows_reference_array_and_amplified_difference() -> None:
    reference = np.zeros((16, 16, 3), dtype=np.float32)
    array = np.full((16, 16, 3), 0.01, dtype=np.float32)
    sheet = side_by_side(reference, array, amplification=50.0)
    middle = sheet[sheet.shape[0] // 2, :, 0]
    panel = sheet.shape[1] // 3
    assert [int(middle[panel // 2 + i * panel]) for i in range(3)] == [0, 3, 128]
    assert sheet.shape[0] >= 256
    # The caption strip holds ink above each panel.
    strip = sheet[:24].min(axis=(0, 2))
    assert all(strip[i * panel : (i + 1) * panel].min() < 128 for i in range(3))


def test_side_by_side_needs_equal_shapes() -> None:
    with pytest.raises(SceneError, match="shapes"):
        side_by_side(gradient(2, 2), gradient(2, 3))
