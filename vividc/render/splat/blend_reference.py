"""Front-to-back blending of depth-sorted splats in float32: what the blending kernel must equal.

Semantics and order of operations: Kerbl et al., 3D Gaussian Splatting (2023), reference
rasteriser, forward pass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.crop import Crop, check_inside, tiles_meeting
from vividc.render.splat.splat import Splats, TileLists

ALPHA_MAX = np.float32(0.99)
ALPHA_MIN = np.float32(1.0 / 255.0)
TRANSMITTANCE_MIN = np.float32(1e-4)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_LIST_CHUNK = 64
"""Splats whose alpha is computed at once; small enough to stop soon after all pixels have."""


@dataclass(frozen=True, slots=True, eq=False)
class Blended:
    """A blended rectangle of pixels and what it cost.

    Attributes
    ----------
    rgbt
        [height, width, 4] float32: accumulated r, g, b without background, transmittance T.
    evaluated
        [height, width] int32 list entries looked at, including the one that stopped the pixel.
    blended
        [height, width] int32 entries that contributed colour.
    exponentials
        [height, width] int32 entries for which exp was needed.
    """

    rgbt: Float32Array
    evaluated: Int32Array
    blended: Int32Array
    exponentials: Int32Array


def _float32_exp(values: Float32Array) -> Float32Array:
    return np.exp(values)


@dataclass(frozen=True, slots=True)
class BlendOptions:
    """Switches of the reference.

    Attributes
    ----------
    lookahead
        Lookahead Culling II: entries whose exponent is below ln(1 / (255 opacity)) - `margin` are
        culled before exp, which is not taken of them.
    margin
        How much below that an exponent must be. From 1e-5 on, more than exp, log and a product
        can err in float32, the picture is the same to the last bit; a negative margin culls
        entries that would be seen.
    exponential
        Takes exponents, float32 [n] of at most 0, to their exp: the place for a quantised one.
    """

    lookahead: bool = False
    margin: float = 1e-5
    exponential: Callable[[Float32Array], Float32Array] = _float32_exp


EXACT = BlendOptions()


def exponent_threshold(opacity: Float32Array, margin: float) -> Float32Array:
    """Return the least exponent of a visible entry of each `opacity` [n], lowered by `margin`.

    alpha = opacity exp(power) < 1/255 where power < ln(1 / (255 opacity)); +inf at opacity 0.
    """
    with np.errstate(divide="ignore"):
        exponent = np.log(ALPHA_MIN / opacity)
    threshold: Float32Array = exponent - np.float32(margin)
    return threshold


def blend_image(
    tiles: TileLists,
    crop: Crop | None = None,
    options: BlendOptions = EXACT,
    progress: Callable[[float], None] | None = None,
) -> Blended:
    """Blend the whole image, or only `crop` (pixels of the image the lists were made for).

    `progress` is called with the share of pixels that are done, 0 to 1.
    """
    area = Crop(0, 0, tiles.width, tiles.height) if crop is None else crop
    check_inside(area, tiles.width, tiles.height)
    rgbt = np.zeros((area.height, area.width, 4), dtype=np.float32)
    evaluated = np.zeros((area.height, area.width), dtype=np.int32)
    blended, exponentials = np.zeros_like(evaluated), np.zeros_like(evaluated)
    done = 0
    for tile_x, tile_y, part in tiles_meeting(area):
        block = blend_block(tiles.tile(tile_x, tile_y), part, options)
        place = part.rows_and_columns_in(area)
        rgbt[place], evaluated[place], blended[place] = block.rgbt, block.evaluated, block.blended
        exponentials[place] = block.exponentials
        done += part.pixels
        if progress is not None:
            progress(done / area.pixels)
    return Blended(rgbt, evaluated, blended, exponentials)


def blend_block(splats: Splats, block: Crop, options: BlendOptions = EXACT) -> Blended:
    """Blend depth-sorted `splats` over the pixels of `block` (image pixel indices).

    For each splat in order: skip if power > 0 or alpha < 1/255; stop the pixel, without adding,
    if its transmittance would fall under 1e-4; else add colour * alpha * T.
    """
    accumulated = np.zeros((block.pixels, 3), dtype=np.float32)
    transmittance = np.ones(block.pixels, dtype=np.float32)
    evaluated = np.zeros(block.pixels, dtype=np.int32)
    blended = np.zeros(block.pixels, dtype=np.int32)
    exponentials = np.zeros(block.pixels, dtype=np.int32)
    live = np.ones(block.pixels, dtype=np.bool_)
    colour = np.stack((splats.red, splats.green, splats.blue), axis=1)
    for start in range(0, len(splats), _LIST_CHUNK):
        chunk = slice(start, start + _LIST_CHUNK)
        alphas, needed = _alphas(splats, block, chunk, options)
        for alpha, need, rgb in zip(alphas, needed, colour[chunk], strict=True):
            evaluated += live
            exponentials += live & need
            remaining = transmittance * (_ONE - alpha)
            hit = live & (alpha >= ALPHA_MIN)
            stopped = hit & (remaining < TRANSMITTANCE_MIN)
            live &= ~stopped
            hit &= ~stopped
            weighted = (rgb * alpha[:, None]) * transmittance[:, None]
            accumulated = np.where(hit[:, None], accumulated + weighted, accumulated)
            transmittance = np.where(hit, remaining, transmittance)
            blended += hit
        if not live.any():
            break
    shape = (block.height, block.width)
    rgbt = np.concatenate((accumulated, transmittance[:, None]), axis=1)
    counts = (count.reshape(shape) for count in (evaluated, blended, exponentials))
    return Blended(rgbt.reshape(*shape, 4), *counts)


def over_background(rgbt: Float32Array, background: float = 1.0) -> Float32Array:
    """Return colour + T * background, [..., 3] float32, from [..., 4] (r, g, b, T)."""
    return rgbt[..., :3] + rgbt[..., 3:] * np.float32(background)


def _alphas(
    splats: Splats, block: Crop, chunk: slice, options: BlendOptions
) -> tuple[Float32Array, npt.NDArray[np.bool_]]:
    """Return alpha of the splats of `chunk` at each pixel [n, pixels], and where exp was needed.

    Alpha is 0 where it was not: where power > 0 or, with lookahead, below the threshold.
    """
    pixel_x = np.arange(block.x0, block.x0 + block.width, dtype=np.float32)
    pixel_y = np.arange(block.y0, block.y0 + block.height, dtype=np.float32)
    dx = splats.mean_x[chunk, None, None] - pixel_x[None, None, :]
    dy = splats.mean_y[chunk, None, None] - pixel_y[None, :, None]
    a, b, c, opacity = (
        array[chunk, None, None]
        for array in (splats.conic_a, splats.conic_b, splats.conic_c, splats.opacity)
    )
    power = -_HALF * (a * dx * dx + c * dy * dy) - b * dx * dy
    needed = ~(power > 0)
    if options.lookahead:
        needed &= power >= exponent_threshold(opacity, options.margin)
    peak = np.broadcast_to(opacity, power.shape)[needed]
    alpha = np.zeros_like(power)
    alpha[needed] = np.minimum(ALPHA_MAX, peak * options.exponential(power[needed]))
    shape = (len(alpha), block.pixels)
    return alpha.reshape(shape), needed.reshape(shape)
