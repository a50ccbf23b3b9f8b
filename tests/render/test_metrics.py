"""PSNR."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vividc.render import SceneError, psnr


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
