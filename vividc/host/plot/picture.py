"""The display list: what a picture consists of, in points, with the origin at the top left."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

from vividc.host.plot.colours import INK

if TYPE_CHECKING:
    from PIL import ImageFont

Anchor = Literal["start", "middle", "end"]


@dataclass(frozen=True, slots=True)
class Rect:
    """A rectangle. `fill` or `stroke` None: not painted. `title` is shown on hovering (SVG)."""

    x: float
    y: float
    width: float
    height: float
    fill: str | None = None
    stroke: str | None = INK
    stroke_width: float = 1.0
    radius: float = 0.0
    title: str = ""


@dataclass(frozen=True, slots=True)
class Line:
    """A line through two or more points, with an arrow head at its end if asked for."""

    points: tuple[tuple[float, float], ...]
    stroke: str = INK
    stroke_width: float = 1.0
    arrow: bool = False
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Circle:
    """A disc around (x, y)."""

    x: float
    y: float
    radius: float
    fill: str | None = None
    stroke: str | None = INK
    stroke_width: float = 1.0


@dataclass(frozen=True, slots=True)
class Text:
    """One line of text whose middle height is `y`; `size` is the font's size."""

    x: float
    y: float
    text: str
    size: float = 10.0
    anchor: Anchor = "start"
    fill: str = INK
    bold: bool = False


Shape = Rect | Line | Circle | Text


@dataclass(frozen=True, slots=True)
class Picture:
    """A canvas and what is painted on it, first shapes lowest."""

    width: float
    height: float
    shapes: tuple[Shape, ...]
    title: str = ""

    if TYPE_CHECKING:  # attached by `svg`

        def _repr_svg_(self) -> str:
            """What a notebook shows."""


def translated(shape: Shape, dx: float, dy: float) -> Shape:
    """The shape moved by (dx, dy)."""
    if isinstance(shape, Line):
        return replace(shape, points=tuple((x + dx, y + dy) for x, y in shape.points))
    return replace(shape, x=shape.x + dx, y=shape.y + dy)


@lru_cache(maxsize=4096)
def text_width(text: str, size: float) -> float:
    """Width of a line of text in the font that PNG uses; SVG viewers' fonts are about as wide."""
    return float(font(round(size * _FINE)).getlength(text)) / _FINE


@lru_cache(maxsize=64)
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font of `size` pixels that Pillow brings along."""
    from PIL import ImageFont  # noqa: PLC0415 - not for those who draw nothing

    return ImageFont.load_default(size)


_FINE = 4
