"""Pictures for people: PNG files and captioned side-by-side comparisons."""

from __future__ import annotations

import os
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from vividc.errors import demand_type
from vividc.host.files import write_whole
from vividc.render.arrays import Float32Array, UInt8Array
from vividc.render.errors import SceneError

_BACKGROUND = 255
_INK = 0
_MARGIN_PX = 8
_CAPTION_PX = 16
_MIN_PANEL_PX = 256
_BYTE_MAX = 255
_COLOUR_AXES = 3


def to_uint8(image: Float32Array) -> UInt8Array:
    """Return [height, width, 3] uint8, rounded, from an image in 0..1; values outside clip.

    Raises
    ------
    SceneError
        The image is not [height, width, 3], or holds nan.
    """
    demand_type(image, np.ndarray, "an image", "give an array [height, width, 3]")
    if image.ndim != _COLOUR_AXES or image.shape[2] != _COLOUR_AXES or image.size == 0:
        raise SceneError(f"an image must be [height, width, 3], got shape {image.shape}")
    if np.isnan(image).any():
        raise SceneError("the image holds nan", hint="some pixel was never written")
    return np.rint(np.clip(image, 0.0, 1.0) * _BYTE_MAX).astype(np.uint8)


def write_png(path: Path | str, image: Float32Array | UInt8Array) -> None:
    """Write [height, width, 3], float 0..1 or uint8, as an 8-bit sRGB PNG."""
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    demand_type(image, np.ndarray, "an image", "give an array [height, width, 3]")
    if image.dtype == np.uint8 and image.shape[2:] != (_COLOUR_AXES,):
        raise SceneError(f"an image must be [height, width, 3], got shape {image.shape}")
    pixels = image if image.dtype == np.uint8 else to_uint8(image.astype(np.float32))
    data = BytesIO()
    Image.fromarray(pixels).save(data, format="PNG")
    write_whole(Path(path), data.getvalue(), SceneError)


def upscale_nearest(image: Float32Array, factor: int) -> Float32Array:
    """Return the image with every pixel repeated `factor` times along both axes."""
    demand_type(image, np.ndarray, "an image", "give an array [height, width, 3]")
    if image.ndim < _COLOUR_AXES - 1:
        raise SceneError(f"an image must be [height, width, ...], got shape {image.shape}")
    demand_type(factor, int, "the factor", "give an integer from 1 on")
    if factor < 1:
        raise SceneError(f"cannot upscale by {factor}", hint="the factor is a positive integer")
    return image.repeat(factor, axis=0).repeat(factor, axis=1)


def side_by_side(
    reference: Float32Array, array: Float32Array, amplification: float = 1.0
) -> UInt8Array:
    """Return three captioned pictures beside each other: the reference, the array's, and the
    difference times `amplification`.

    Inputs are [height, width, 3] in 0..1. Small images are enlarged by a whole factor, so that
    single pixels stay visible. The result is [H, W, 3] uint8.
    """
    if reference.shape != array.shape:
        raise SceneError(f"cannot compare shapes {reference.shape} and {array.shape}")
    difference = np.abs(reference - array) * np.float32(amplification)
    panels = (
        ("reference", reference),
        ("array", array),
        (f"|difference| x{amplification:g}", difference),
    )
    factor = max(1, -(-_MIN_PANEL_PX // max(reference.shape[1], 1)))
    enlarged = [upscale_nearest(image, factor) for _, image in panels]
    height, width = enlarged[0].shape[:2]
    sheet = Image.new(
        "RGB",
        (len(panels) * (width + _MARGIN_PX) + _MARGIN_PX, height + _CAPTION_PX + 2 * _MARGIN_PX),
        (_BACKGROUND,) * 3,
    )
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default()
    for position, ((caption, _), image) in enumerate(zip(panels, enlarged, strict=True)):
        left = _MARGIN_PX + position * (width + _MARGIN_PX)
        draw.text((left, _MARGIN_PX // 2), caption, fill=(_INK,) * 3, font=font)
        sheet.paste(Image.fromarray(to_uint8(image)), (left, _MARGIN_PX + _CAPTION_PX))
    return np.asarray(sheet)
