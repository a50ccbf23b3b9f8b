"""A picture as PNG, painted by Pillow at a multiple of its size and scaled down."""

from __future__ import annotations

import io
import math
from itertools import pairwise
from typing import TYPE_CHECKING

from vividc.errors import VividcError
from vividc.host.plot.colours import PAPER
from vividc.host.plot.geometry import arrow_head, shaft
from vividc.host.plot.picture import Circle, Line, Picture, Rect, Shape, Text, font

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

_OVERSAMPLE = 2
_MAX_PIXELS = 150_000_000
_PIL_ANCHOR = {"start": "lm", "middle": "mm", "end": "rm"}


def to_png(picture: Picture, scale: float = 2.0) -> bytes:
    """The picture as a PNG file of `scale` pixels a point.

    Raises
    ------
    VividcError
        The picture is too large for a PNG even at a smaller scale.
    """
    buffer = io.BytesIO()
    to_image(picture, scale).save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


def to_image(picture: Picture, scale: float = 2.0) -> Image.Image:
    """The picture as a Pillow image; `scale` shrinks, to 1 at the least, where it would not fit.

    Raises
    ------
    VividcError
        See `to_png`.
    """
    area = picture.width * picture.height * _OVERSAMPLE**2
    scale = min(scale, max(1.0, math.sqrt(_MAX_PIXELS / area)))
    if area * scale**2 > _MAX_PIXELS:
        raise VividcError(
            f"a picture of {picture.width:.0f} x {picture.height:.0f} points is too large for PNG",
            hint="write it as SVG, to a name that ends in .svg",
        )
    from PIL import Image, ImageDraw  # noqa: PLC0415 - not for those who draw nothing

    factor = scale * _OVERSAMPLE
    size = (math.ceil(picture.width * factor), math.ceil(picture.height * factor))
    image = Image.new("RGB", size, PAPER)
    brush = _Brush(ImageDraw.Draw(image), factor)
    for shape in picture.shapes:
        brush.paint(shape)
    small = (math.ceil(picture.width * scale), math.ceil(picture.height * scale))
    return image.resize(small, Image.Resampling.BOX)


class _Brush:
    """Paints shapes on an image that is `factor` pixels a point."""

    def __init__(self, draw: ImageDraw.ImageDraw, factor: float) -> None:
        self.draw = draw
        self.factor = factor

    def paint(self, shape: Shape) -> None:
        if isinstance(shape, Rect):
            self.rect(shape)
        elif isinstance(shape, Circle):
            self.circle(shape)
        elif isinstance(shape, Text):
            self.text(shape)
        else:
            self.line(shape)

    def rect(self, shape: Rect) -> None:
        box = self.box(shape.x, shape.y, shape.x + shape.width, shape.y + shape.height)
        self.draw.rounded_rectangle(
            box,
            radius=shape.radius * self.factor,
            fill=shape.fill,
            outline=shape.stroke,
            width=self.pen(shape.stroke_width),
        )

    def circle(self, shape: Circle) -> None:
        radius = shape.radius
        box = self.box(shape.x - radius, shape.y - radius, shape.x + radius, shape.y + radius)
        width = self.pen(shape.stroke_width)
        self.draw.ellipse(box, fill=shape.fill, outline=shape.stroke, width=width)

    def text(self, shape: Text) -> None:
        size = max(1, round(shape.size * self.factor))
        place = (shape.x * self.factor, shape.y * self.factor)
        self.draw.text(
            place,
            shape.text,
            fill=shape.fill,
            font=font(size),
            anchor=_PIL_ANCHOR[shape.anchor],
            stroke_width=round(size / 36) if shape.bold else 0,
            stroke_fill=shape.fill,
        )

    def line(self, shape: Line) -> None:
        width = self.pen(shape.stroke_width)
        points = shaft(shape)
        if shape.dashed:
            self.dashes(points, shape)
        else:
            self.draw.line(self.scaled(points), fill=shape.stroke, width=width, joint="curve")
        if shape.arrow:
            self.draw.polygon(self.scaled(arrow_head(shape)), fill=shape.stroke)

    def dashes(self, points: tuple[tuple[float, float], ...], shape: Line) -> None:
        dash = 3 * shape.stroke_width
        for (x0, y0), (x1, y1) in pairwise(points):
            length = math.hypot(x1 - x0, y1 - y0)
            for number in range(math.ceil(length / (2 * dash))):
                begin = 2 * number * dash / length
                end = min(1.0, begin + dash / length)
                ends = tuple((x0 + at * (x1 - x0), y0 + at * (y1 - y0)) for at in (begin, end))
                width = self.pen(shape.stroke_width)
                self.draw.line(self.scaled(ends), fill=shape.stroke, width=width)

    def scaled(self, points: tuple[tuple[float, float], ...]) -> list[tuple[float, float]]:
        return [(x * self.factor, y * self.factor) for x, y in points]

    def box(self, left: float, top: float, right: float, bottom: float) -> list[float]:
        return [edge * self.factor for edge in (left, top, right, bottom)]

    def pen(self, width: float) -> int:
        return max(1, round(width * self.factor))
