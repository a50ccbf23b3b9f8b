"""Image quality measures."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from vividc.errors import quoted
from vividc.render.errors import SceneError

_WINDOW_PX = 11
_WINDOW_SIGMA_PX = 1.5
_C1 = 0.01**2
_C2 = 0.03**2
_COLOUR_AXES = 3

Float64Array = npt.NDArray[np.float64]


def psnr(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Return the peak signal-to-noise ratio in dB for a peak of 1; infinite for equal images.

    Values are compared as given: clip beforehand where the displayed picture is meant.
    """
    left, right = _floats(a), _floats(b)
    if left.shape != right.shape or left.size == 0:
        raise SceneError(
            f"cannot compare images of shapes {left.shape} and {right.shape}",
            hint="render both at the same size",
        )
    error = float(np.mean((left - right) ** 2))
    return math.inf if error == 0 else -10 * math.log10(error)


def _floats(image: npt.ArrayLike) -> Float64Array:
    try:
        return np.asarray(image, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SceneError(
            f"an image cannot be {quoted(image)}", hint="give an array of numbers"
        ) from error


def ssim(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Return the structural similarity of two [height, width, channels] images, at most 1.

    Wang et al., Image Quality Assessment (2004): a Gaussian window of 11x11 pixels with sigma 1.5,
    K1 = 0.01, K2 = 0.03 and a range of 1, averaged over all whole windows and the channels.
    """
    left, right = _floats(a), _floats(b)
    if left.shape != right.shape or left.ndim != _COLOUR_AXES or min(left.shape[:2]) < _WINDOW_PX:
        raise SceneError(
            f"cannot compare the structure of images of shapes {left.shape} and {right.shape}",
            hint=f"both [height, width, channels], at least {_WINDOW_PX}x{_WINDOW_PX}",
        )
    mean_left, mean_right = _blurred(left), _blurred(right)
    variance_left = _blurred(left * left) - mean_left**2
    variance_right = _blurred(right * right) - mean_right**2
    covariance = _blurred(left * right) - mean_left * mean_right
    luminance = (2 * mean_left * mean_right + _C1) / (mean_left**2 + mean_right**2 + _C1)
    structure = (2 * covariance + _C2) / (variance_left + variance_right + _C2)
    return float(np.mean(luminance * structure))


def _blurred(image: Float64Array) -> Float64Array:
    """Return the weighted mean over every whole window, [height - 10, width - 10, channels]."""
    offset = np.arange(_WINDOW_PX) - _WINDOW_PX // 2
    weights = np.exp(-(offset**2) / (2 * _WINDOW_SIGMA_PX**2))
    weights /= weights.sum()
    rows = sliding_window_view(image, _WINDOW_PX, axis=0) @ weights
    blurred: Float64Array = sliding_window_view(rows, _WINDOW_PX, axis=1) @ weights
    return blurred
