"""Lists of small blocks: nothing that is seen is dropped, and what is far is."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render import BlendOptions, Crop, Splats, TileLists, blend_block, blend_image, seen_in
from vividc.render.arrays import frozen_float32
from vividc.render.splat.blend_reference import ALPHA_MIN, exponent_threshold


def random_splats(rng: np.random.Generator, count: int) -> Splats:
    """Return splats around the origin, thin ones and indefinite ones among them."""
    angle, long, short = (
        rng.uniform(0, 3, count),
        rng.uniform(1, 40, count),
        rng.uniform(0.5, 3, count),
    )
    cos, sin = np.cos(angle), np.sin(angle)
    a, c = cos**2 / long**2 + sin**2 / short**2, sin**2 / long**2 + cos**2 / short**2
    b = cos * sin * (1 / long**2 - 1 / short**2) * np.where(rng.random(count) < 0.05, 4, 1)
    columns = (
        *rng.uniform(-30, 30, (2, count)), a, b, c,
        rng.choice([0.0, 0.003, 1 / 255, 0.0041, 0.3, 1.0], count),
        *rng.uniform(0, 1, (3, count)),
    )  # fmt: skip
    return Splats(*(frozen_float32(column) for column in columns))


@pytest.mark.parametrize("seed", range(12))
def test_the_picture_of_a_block_keeps_every_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    splats = random_splats(rng, 300)
    block = Crop(*rng.integers(-20, 15, 2), *rng.integers(1, 12, 2))
    seen = seen_in(splats, block)
    assert 0 < len(seen) < len(splats)
    expected, result = blend_block(splats, block), blend_block(seen, block)
    np.testing.assert_array_equal(result.rgbt, expected.rgbt)
    np.testing.assert_array_equal(result.blended, expected.blended)


def test_culling_is_exact_for_well_conditioned_splats() -> None:
    """Of those that stay, nearly all are seen: the rectangle between the pixels is the rest."""
    rng = np.random.default_rng(1)
    count = 400
    columns = (
        *rng.uniform(-30, 30, (2, count)), *np.full((3, count), [[0.1], [0.0], [0.1]]),
        np.full(count, 0.5), *np.ones((3, count)),
    )  # fmt: skip
    splats = Splats(*(frozen_float32(column) for column in columns))
    block = Crop(-4, -4, 8, 8)
    x, y = np.meshgrid(np.arange(-4, 4), np.arange(-4, 4))
    dx, dy = splats.mean_x[:, None, None] - x, splats.mean_y[:, None, None] - y
    alpha = 0.5 * np.exp(-0.05 * (dx**2 + dy**2))
    seen = (alpha >= ALPHA_MIN).any(axis=(1, 2)).sum()
    assert seen <= len(seen_in(splats, block)) <= 1.05 * seen


def test_an_empty_list_stays_empty() -> None:
    splats = random_splats(np.random.default_rng(0), 0)
    assert len(seen_in(splats, Crop(0, 0, 8, 8))) == 0


@pytest.mark.parametrize("seed", range(6))
def test_lookahead_culling_2_keeps_every_bit(seed: int) -> None:
    splats, block = random_splats(np.random.default_rng(seed), 200), Crop(-8, -8, 16, 16)
    early = blend_block(splats, block, BlendOptions(lookahead=True))
    late = blend_block(splats, block)
    np.testing.assert_array_equal(early.rgbt, late.rgbt)
    np.testing.assert_array_equal(early.evaluated, late.evaluated)
    assert (early.blended <= early.exponentials).all()
    assert early.exponentials.sum() < late.exponentials.sum() <= late.evaluated.sum()


def test_lookahead_culling_2_on_mic(mic_tiles: TileLists) -> None:
    crop = Crop(80, 24, 24, 16)
    early = blend_image(mic_tiles, crop, BlendOptions(lookahead=True))
    late = blend_image(mic_tiles, crop)
    np.testing.assert_array_equal(early.rgbt, late.rgbt)
    assert late.exponentials.sum() > 10 * early.exponentials.sum()
    assert early.exponentials.sum() < 1.01 * early.blended.sum() + crop.pixels


def test_the_margin_is_adjustable() -> None:
    splats, block = random_splats(np.random.default_rng(3), 200), Crop(-8, -8, 16, 16)
    counts = [
        int(blend_block(splats, block, BlendOptions(True, margin)).exponentials.sum())
        for margin in (-2.0, 0.0, 2.0)
    ]
    assert counts[0] < counts[1] < counts[2]
    lossy = blend_block(splats, block, BlendOptions(True, -2.0))
    assert not np.array_equal(lossy.rgbt, blend_block(splats, block).rgbt)


def test_threshold_of_an_opacity() -> None:
    opacity = frozen_float32([1, 0.5, 0])
    expected = [-np.log(255), -np.log(127.5), np.inf]
    np.testing.assert_allclose(exponent_threshold(opacity, 0), expected, rtol=1e-6)
    assert (exponent_threshold(opacity, 0.5)[:2] < exponent_threshold(opacity, 0)[:2]).all()


def test_another_exp_can_stand_in() -> None:
    splats, block = random_splats(np.random.default_rng(3), 50), Crop(0, 0, 8, 8)
    halves = BlendOptions(
        True, exponential=lambda x: np.exp(x).astype(np.float16).astype(np.float32)
    )
    coarse, fine = blend_block(splats, block, halves).rgbt, blend_block(splats, block).rgbt
    assert not np.array_equal(coarse, fine)
    np.testing.assert_allclose(coarse, fine, atol=5e-3)
