"""Blending against a slow scalar oracle, against the reference renders, and rule by rule."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc.render import (
    Camera,
    Crop,
    Gaussians,
    SceneError,
    Splats,
    TileLists,
    blend_block,
    blend_image,
    load_reference_images,
    over_background,
    psnr,
    tile_lists,
)
from vividc.render.arrays import frozen_float32

F = np.float32


def random_splats(count: int, seed: int) -> Splats:
    """Return splats over an 8x6 block at (16, 32); some conics are not positive definite."""
    rng = np.random.default_rng(seed)
    columns = (
        rng.uniform(14, 26, count), rng.uniform(30, 40, count),
        rng.uniform(0.02, 0.6, count), rng.uniform(-0.4, 0.4, count),
        rng.uniform(0.02, 0.6, count), rng.uniform(0, 1, count),
        *rng.uniform(0, 1.2, (3, count)),
    )  # fmt: skip
    return Splats(*(frozen_float32(column) for column in columns))


def splat(opacity: float, conic: tuple[float, float, float] = (0.1, 0, 0.1)) -> tuple[float, ...]:
    """Return one white splat centred on pixel (0, 0)."""
    return (0.0, 0.0, *conic, opacity, 1.0, 1.0, 1.0)


def splat_list(*rows: tuple[float, ...]) -> Splats:
    return Splats(*(frozen_float32(column) for column in zip(*rows, strict=True)))


def scalar_oracle(splats: Splats, x: int, y: int) -> tuple[list[np.float32], int, int]:
    """Blend one pixel, one splat at a time, with float32 scalars: rgbT, evaluated, blended."""
    red = green = blue = F(0)
    transmittance = F(1)
    evaluated = blended = 0
    for mx, my, a, b, c, opacity, r, g, bl in zip(*splats.arrays().values(), strict=True):
        evaluated += 1
        dx, dy = mx - F(x), my - F(y)
        power = F(-0.5) * (a * dx * dx + c * dy * dy) - b * dx * dy
        if power > 0:
            continue
        alpha = min(F(0.99), opacity * np.exp(power))
        if alpha < F(1) / F(255):
            continue
        remaining = transmittance * (F(1) - alpha)
        if remaining < F(1e-4):
            break
        red += r * alpha * transmittance
        green += g * alpha * transmittance
        blue += bl * alpha * transmittance
        transmittance = remaining
        blended += 1
    return [red, green, blue, transmittance], evaluated, blended


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 200])
def test_equals_the_scalar_oracle(count: int) -> None:
    block = Crop(16, 32, 8, 6)
    splats = random_splats(count, seed=count)
    result = blend_block(splats, block)
    assert result.rgbt.dtype == np.float32
    for row in range(block.height):
        for column in range(block.width):
            rgbt, evaluated, blended = scalar_oracle(splats, 16 + column, 32 + row)
            # One ulp a step at most: numpy's scalar and vector exp may round differently.
            np.testing.assert_allclose(result.rgbt[row, column], rgbt, rtol=1e-5, atol=1e-6)
            assert result.evaluated[row, column] == evaluated
            assert result.blended[row, column] == blended


def test_the_oracle_run_meets_every_rule() -> None:
    """Long random lists do stop early and do skip, or the comparison above would prove little."""
    result = blend_block(random_splats(200, seed=200), Crop(16, 32, 8, 6))
    assert (result.evaluated < 200).any()
    assert (result.blended < result.evaluated - 1).any()


def test_positive_power_is_skipped() -> None:
    indefinite = splat(0.9, conic=(0.1, 1.0, 0.1))
    result = blend_block(splat_list(indefinite), Crop(-1, 1, 1, 1))
    assert result.rgbt.ravel().tolist() == [0, 0, 0, 1]
    assert (result.evaluated.item(), result.blended.item()) == (1, 0)


@pytest.mark.parametrize(("opacity", "blended"), [(0.0039, 0), (1 / 255, 1), (0.0040, 1)])
def test_alpha_under_one_255th_is_skipped(opacity: float, blended: int) -> None:
    result = blend_block(splat_list(splat(opacity)), Crop(0, 0, 1, 1))
    assert result.blended.item() == blended


def test_alpha_is_capped() -> None:
    result = blend_block(splat_list(splat(1.0)), Crop(0, 0, 1, 1))
    np.testing.assert_array_equal(result.rgbt.ravel()[:3], [F(0.99)] * 3)
    assert result.rgbt.ravel()[3] == F(1) - F(0.99)


def test_the_splat_that_would_end_the_transmittance_is_not_added() -> None:
    """T goes 1, 0.01, and would go to 0.01 * 0.005: stop there, though a later one would fit."""
    rows = (splat(0.99), splat(0.995), splat(0.5))
    result = blend_block(splat_list(*rows), Crop(0, 0, 1, 1))
    assert (result.evaluated.item(), result.blended.item()) == (2, 1)
    assert result.rgbt.ravel()[3] == F(1) - F(0.99)


def test_background_shows_through_the_transmittance() -> None:
    rgbt = np.array([[[0.1, 0.2, 0.3, 0.5]]], dtype=np.float32)
    np.testing.assert_allclose(over_background(rgbt), [[[0.6, 0.7, 0.8]]], rtol=1e-6)
    np.testing.assert_allclose(over_background(rgbt, 0.0), [[[0.1, 0.2, 0.3]]], rtol=1e-6)


@pytest.mark.parametrize("view", [0, 1])
def test_mic_equals_the_reference_render(
    mic: Gaussians, mic_cameras: tuple[Camera, ...], mic_views: Path, view: int
) -> None:
    """The reference is a float64 render; 95 and 103 dB were measured."""
    image = over_background(blend_image(tile_lists(mic, mic_cameras[view])).rgbt)
    assert psnr(image, load_reference_images(mic_views)[view]) > 80


def test_a_crop_is_a_part_of_the_whole(mic_tiles: TileLists) -> None:
    whole = blend_image(mic_tiles)
    crop = Crop(90, 130, 23, 37)
    part = blend_image(mic_tiles, crop)
    place = np.s_[130:167, 90:113]
    np.testing.assert_array_equal(part.rgbt, whole.rgbt[place])
    np.testing.assert_array_equal(part.evaluated, whole.evaluated[place])
    np.testing.assert_array_equal(part.blended, whole.blended[place])


def test_a_crop_must_lie_in_the_image(mic_tiles: TileLists) -> None:
    with pytest.raises(SceneError, match="not a part of the 200x200 image"):
        blend_image(mic_tiles, Crop(190, 0, 16, 16))
