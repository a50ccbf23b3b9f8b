"""Image quality measures."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from vividc.render.errors import SceneError


def psnr(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Return the peak signal-to-noise ratio in dB for a peak of 1; infinite for equal images.

    Values are compared as given: clip beforehand where the displayed picture is meant.
    """
    left, right = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if left.shape != right.shape or left.size == 0:
        raise SceneError(
            f"cannot compare images of shapes {left.shape} and {right.shape}",
            hint="render both at the same size",
        )
    error = float(np.mean((left - right) ** 2))
    return math.inf if error == 0 else -10 * math.log10(error)
