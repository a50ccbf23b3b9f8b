"""Pictures as display lists: shapes on a canvas, written as SVG or PNG from the same list.

In order: `colours`, `geometry`, `picture`, `svg`, `png`, `write` (by the ending of a path).
"""

from vividc.host.plot.colours import INK, OKABE_ITO, PAPER, readable_on, tint
from vividc.host.plot.picture import (
    Circle,
    Line,
    Picture,
    Rect,
    Shape,
    Text,
    text_width,
    translated,
)
from vividc.host.plot.png import to_image, to_png
from vividc.host.plot.svg import to_svg
from vividc.host.plot.write import FORMATS, check_picture_path, encode

__all__ = [
    "FORMATS",
    "INK",
    "OKABE_ITO",
    "PAPER",
    "Circle",
    "Line",
    "Picture",
    "Rect",
    "Shape",
    "Text",
    "check_picture_path",
    "encode",
    "readable_on",
    "text_width",
    "tint",
    "to_image",
    "to_png",
    "to_svg",
    "translated",
]
