"""Front-to-back blending of depth-sorted splats in float32: what the blending kernel must equal.

Semantics and order of operations: Kerbl et al., 3D Gaussian Splatting (2023), reference
rasteriser, forward pass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.crop import Crop, check_inside, tiles_meeting
from vividc.render.splat import Splats, TileLists

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
    """

    rgbt: Float32Array
    evaluated: Int32Array
    blended: Int32Array


def blend_image(tiles: TileLists, crop: Crop | None = None) -> Blended:
    """Blend the whole image, or only `crop` (pixels of the image the lists were made for)."""
    area = Crop(0, 0, tiles.width, tiles.height) if crop is None else crop
    check_inside(area, tiles.width, tiles.height)
    rgbt = np.zeros((area.height, area.width, 4), dtype=np.float32)
    evaluated = np.zeros((area.height, area.width), dtype=np.int32)
    blended = np.zeros_like(evaluated)
    for tile_x, tile_y, part in tiles_meeting(area):
        block = blend_block(tiles.tile(tile_x, tile_y), part)
        place = part.rows_and_columns_in(area)
        rgbt[place], evaluated[place], blended[place] = block.rgbt, block.evaluated, block.blended
    return Blended(rgbt, evaluated, blended)


def blend_block(splats: Splats, block: Crop) -> Blended:
    """Blend depth-sorted `splats` over the pixels of `block` (image pixel indices).

    For each splat in order: skip if power > 0 or alpha < 1/255; stop the pixel, without adding,
    if its transmittance would fall under 1e-4; else add colour * alpha * T.
    """
    accumulated = np.zeros((block.pixels, 3), dtype=np.float32)
    transmittance = np.ones(block.pixels, dtype=np.float32)
    evaluated = np.zeros(block.pixels, dtype=np.int32)
    blended = np.zeros(block.pixels, dtype=np.int32)
    live = np.ones(block.pixels, dtype=np.bool_)
    colour = np.stack((splats.red, splats.green, splats.blue), axis=1)
    for start in range(0, len(splats), _LIST_CHUNK):
        alphas = _alphas(splats, block, slice(start, start + _LIST_CHUNK))
        for alpha, rgb in zip(alphas, colour[start : start + _LIST_CHUNK], strict=True):
            evaluated += live
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
    return Blended(rgbt.reshape(*shape, 4), evaluated.reshape(shape), blended.reshape(shape))


def over_background(rgbt: Float32Array, background: float = 1.0) -> Float32Array:
    """Return colour + T * background, [..., 3] float32, from [..., 4] (r, g, b, T)."""
    return rgbt[..., :3] + rgbt[..., 3:] * np.float32(background)


def _alphas(splats: Splats, block: Crop, chunk: slice) -> Float32Array:
    """Return alpha of the splats of `chunk` at each pixel, [n, pixels]; 0 where power > 0."""
    pixel_x = np.arange(block.x0, block.x0 + block.width, dtype=np.float32)
    pixel_y = np.arange(block.y0, block.y0 + block.height, dtype=np.float32)
    dx = splats.mean_x[chunk, None, None] - pixel_x[None, None, :]
    dy = splats.mean_y[chunk, None, None] - pixel_y[None, :, None]
    a, b, c, opacity = (
        array[chunk, None, None]
        for array in (splats.conic_a, splats.conic_b, splats.conic_c, splats.opacity)
    )
    power = -_HALF * (a * dx * dx + c * dy * dy) - b * dx * dy
    # exp of a positive power is never used; the clamp only keeps it from overflowing.
    alpha = np.minimum(ALPHA_MAX, opacity * np.exp(np.minimum(power, np.float32(0))))
    return np.where(power > 0, np.float32(0), alpha).reshape(len(alpha), block.pixels)
