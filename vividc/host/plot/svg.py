"""A picture as SVG text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape

from vividc.host.plot.colours import PAPER
from vividc.host.plot.geometry import arrow_head, shaft
from vividc.host.plot.picture import Circle, Line, Picture, Rect, Shape, Text

_FONT = "Helvetica, Arial, 'DejaVu Sans', sans-serif"
_BASELINE = 0.35
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def to_svg(picture: Picture) -> str:
    """The picture as a complete SVG document; its size is in CSS pixels, one for a point."""
    width, height = _number(picture.width), _number(picture.height)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="{escape(_FONT)}">'
    ]
    if picture.title:
        lines.append(f"<title>{_text(picture.title)}</title>")
    lines.append(f'<rect width="{width}" height="{height}" fill="{PAPER}"/>')
    for shape in picture.shapes:
        lines.extend(_elements(shape))
    return "\n".join([*lines, "</svg>"]) + "\n"


def _elements(shape: Shape) -> Iterator[str]:
    if isinstance(shape, Rect):
        yield _rect(shape)
    elif isinstance(shape, Circle):
        yield (
            f'<circle cx="{_number(shape.x)}" cy="{_number(shape.y)}" '
            f'r="{_number(shape.radius)}"{_paint(shape.fill, shape.stroke, shape.stroke_width)}/>'
        )
    elif isinstance(shape, Text):
        weight = ' font-weight="bold"' if shape.bold else ""
        yield (
            f'<text x="{_number(shape.x)}" y="{_number(shape.y + _BASELINE * shape.size)}" '
            f'font-size="{_number(shape.size)}" text-anchor="{shape.anchor}" '
            f'fill="{shape.fill}"{weight}>{_text(shape.text)}</text>'
        )
    else:
        yield from _line(shape)


def _rect(shape: Rect) -> str:
    radius = f' rx="{_number(shape.radius)}"' if shape.radius else ""
    head = (
        f'<rect x="{_number(shape.x)}" y="{_number(shape.y)}" width="{_number(shape.width)}" '
        f'height="{_number(shape.height)}"{radius}'
        f"{_paint(shape.fill, shape.stroke, shape.stroke_width)}"
    )
    return f"{head}><title>{_text(shape.title)}</title></rect>" if shape.title else f"{head}/>"


def _line(shape: Line) -> Iterator[str]:
    dash = f' stroke-dasharray="{_number(3 * shape.stroke_width)}"' if shape.dashed else ""
    yield (
        f'<polyline points="{_points(shaft(shape))}"'
        f'{_paint(None, shape.stroke, shape.stroke_width)}{dash} stroke-linejoin="round"/>'
    )
    if shape.arrow:
        yield f'<polygon points="{_points(arrow_head(shape))}" fill="{shape.stroke}"/>'


def _points(points: tuple[tuple[float, float], ...]) -> str:
    return " ".join(f"{_number(x)},{_number(y)}" for x, y in points)


def _paint(fill: str | None, stroke: str | None, width: float) -> str:
    painted = f' fill="{fill or "none"}"'
    if stroke is not None:
        painted += f' stroke="{stroke}" stroke-width="{_number(width)}"'
    return painted


def _text(text: str) -> str:
    """Escaped, without what XML cannot hold at all."""
    return escape(_NOT_XML.sub("\ufffd", text), quote=False)


def _number(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


setattr(Picture, "_repr_svg_", to_svg)  # noqa: B010 - a notebook shows pictures as SVG
