"""PSNR and SSIM."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vividc.render import SceneError, psnr, ssim


def test_known_values() -> None:
    black = np.zeros((2, 2, 3), dtype=np.float32)
    assert psnr(black, black) == math.inf
    assert psnr(black, black + 1) == 0.0
    assert psnr(black, black + np.float32(0.1)) == pytest.approx(20.0, abs=1e-5)


def test_shapes_must_agree() -> None:
    with pytest.raises(SceneError, match="shapes"):
        psnr(np.zeros((2, 2)), np.zeros((2, 3)))
    with pytest.raises(SceneError, match="shapes"):
        psnr(np.zeros(0), np.zeros(0))


def ssim_by_windows(a: np.ndarray, b: np.ndarray) -> float:
    """Wang et al. 2004, window by window."""
    offset = np.arange(11) - 5
    weight = np.exp(-(offset[:, None] ** 2 + offset[None, :] ** 2) / (2 * 1.5**2))
    weight = (weight / weight.sum())[:, :, None]
    values = []
    for y in range(a.shape[0] - 10):
        for x in range(a.shape[1] - 10):
            p, q = a[y : y + 11, x : x + 11], b[y : y + 11, x : x + 11]
            mp, mq = (weight * p).sum((0, 1)), (weight * q).sum((0, 1))
            vp, vq = (weight * (p - mp) ** 2).sum((0, 1)), (weight * (q - mq) ** 2).sum((0, 1))
            both = (weight * (p - mp) * (q - mq)).sum((0, 1))
            light = (2 * mp * mq + 1e-4) / (mp**2 + mq**2 + 1e-4)
            values.append(light * (2 * both + 9e-4) / (vp + vq + 9e-4))
    return float(np.mean(values))


def test_ssim_equals_its_definition() -> None:
    rng = np.random.default_rng(3)
    a = rng.random((19, 15, 3))
    b = np.clip(a + rng.normal(0, 0.2, a.shape), 0, 1)
    assert ssim(a, b) == pytest.approx(ssim_by_windows(a, b), abs=1e-9)
    assert ssim(a, b) == pytest.approx(ssim(b, a), abs=1e-12)
    assert 0 < ssim(a, b) < 1


def test_ssim_of_equal_and_of_flat_images() -> None:
    a = np.random.default_rng(1).random((12, 12, 3))
    assert ssim(a, a) == pytest.approx(1, abs=1e-12)
    flat = ssim(np.zeros((11, 11, 3)), np.ones((11, 11, 3)))
    assert flat == pytest.approx(1e-4 / (1 + 1e-4), rel=1e-6)


def test_ssim_needs_a_window() -> None:
    with pytest.raises(SceneError, match="at least 11x11"):
        ssim(np.zeros((10, 20, 3)), np.zeros((10, 20, 3)))
    with pytest.raises(SceneError, match="shapes"):
        ssim(np.zeros((12, 12, 3)), np.zeros((12, 13, 3)))
