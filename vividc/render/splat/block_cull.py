"""Lists of small blocks: the splats of a tile that are visible in a block of its pixels.

A tile's list holds every splat whose square footprint of three standard deviations meets the tile.
Many of them are nowhere in it opaque enough to count; without those the lists are short enough for
a scratchpad, and blending them gives the same picture to the last bit.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vividc.render.crop import Crop
from vividc.render.splat.blend_reference import ALPHA_MIN
from vividc.render.splat.splat import Splats

_ROUNDING = 16 * float(np.finfo(np.float32).eps)
"""Bound of the error of a float32 exponent, relative to the sum of its terms' magnitudes."""
_MARGIN = 1e-5
"""Exponents that differ by less may give the same float32 alpha."""

Float64Array = npt.NDArray[np.float64]


def seen_in(splats: Splats, block: Crop) -> Splats:
    """Return the splats, in their order, that may reach alpha 1/255 at some pixel of `block`.

    The least of the quadratic form over the block's rectangle is taken exactly: at the mean where
    that lies within, else on one of the four edges (the form is convex there).
    """
    left, right = _offsets(splats.mean_x, block.x0, block.width)
    top, bottom = _offsets(splats.mean_y, block.y0, block.height)
    a, b, c, opacity = (
        array.astype(np.float64)
        for array in (splats.conic_a, splats.conic_b, splats.conic_c, splats.opacity)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        least = np.minimum.reduce(
            [
                *(_least_along(a, b, c, edge, top, bottom) for edge in (left, right)),
                *(_least_along(c, b, a, edge, left, right) for edge in (top, bottom)),
            ]
        )
        needed = 2 * np.log(255 * opacity)
    within = (left <= 0) & (right >= 0) & (top <= 0) & (bottom >= 0)
    least = np.where(within, 0.0, least)
    reach_x = np.maximum(np.abs(left), np.abs(right))
    reach_y = np.maximum(np.abs(top), np.abs(bottom))
    terms = np.abs(a) * reach_x**2 + np.abs(c) * reach_y**2 + 2 * np.abs(b) * reach_x * reach_y
    convex = (a > 0) & (c > 0) & (a * c > b * b)
    unseen = least > needed + _MARGIN + _ROUNDING * terms
    kept = ~(convex & unseen) & (splats.opacity >= ALPHA_MIN)
    return splats.take(np.flatnonzero(kept))


def _offsets(mean: npt.NDArray[np.float32], first: int, count: int) -> tuple[Float64Array, ...]:
    """Return mean - last and mean - first pixel: the range of offsets in the block."""
    centre = mean.astype(np.float64)
    return centre - (first + count - 1), centre - first


def _least_along(
    across: Float64Array,
    mixed: Float64Array,
    along: Float64Array,
    edge: Float64Array,
    low: Float64Array,
    high: Float64Array,
) -> Float64Array:
    """Return the least of across u^2 + 2 mixed u v + along v^2 at u = `edge`, v in [low, high]."""
    v = np.clip(-mixed * edge / along, low, high)
    least: Float64Array = across * edge**2 + 2 * mixed * edge * v + along * v**2
    return least
