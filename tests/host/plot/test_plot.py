"""One display list, two formats."""

from __future__ import annotations

import io
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from vividc.errors import VividcError
from vividc.host.plot import (
    OKABE_ITO,
    Circle,
    Line,
    Picture,
    Rect,
    Text,
    encode,
    readable_on,
    text_width,
    tint,
    to_image,
    to_png,
    to_svg,
    translated,
)

RED, BLUE = "#ff0000", "#0000ff"
SHAPES = (
    Rect(0, 0, 20, 10, fill=RED, stroke=None),
    Circle(30, 20, 5, fill=BLUE, stroke=None),
    Line(((0, 30), (40, 30)), stroke=BLUE, arrow=True),
    Text(20, 5, "a<b>&c", anchor="middle"),
)
PICTURE = Picture(40, 40, SHAPES, "t")
SVG = "{http://www.w3.org/2000/svg}"


def test_svg_is_well_formed_and_holds_every_shape() -> None:
    root = ElementTree.fromstring(to_svg(PICTURE))
    kinds = [child.tag.removeprefix(SVG) for child in root]
    assert kinds == ["title", "rect", "rect", "circle", "polyline", "polygon", "text"]
    assert root[-1].text == "a<b>&c"


@given(st.text())
def test_any_text_stays_well_formed(text: str) -> None:
    ElementTree.fromstring(to_svg(Picture(9, 9, (Text(0, 0, text), Rect(0, 0, 1, 1, title=text)))))


def test_png_has_the_colours_where_the_shapes_are() -> None:
    image = Image.open(io.BytesIO(to_png(PICTURE, scale=2)))
    assert image.size == (80, 80)
    assert image.getpixel((4, 4)) == (255, 0, 0)
    assert image.getpixel((60, 40)) == (0, 0, 255)
    assert image.getpixel((20, 60)) == (0, 0, 255)
    assert image.getpixel((4, 76)) == (255, 255, 255)


def test_the_arrow_ends_at_the_last_point() -> None:
    image = to_image(Picture(40, 10, (Line(((0, 5), (30, 5)), stroke=RED, arrow=True),)), scale=4)
    assert image.getpixel((116, 20)) == (255, 0, 0)
    assert image.getpixel((126, 20)) == (255, 255, 255)


def test_a_dashed_line_has_gaps() -> None:
    image = to_image(Picture(60, 4, (Line(((0, 2), (60, 2)), RED, 1, dashed=True),)), scale=1)
    row = [image.getpixel((x, 2)) for x in range(60)]
    assert len(set(row)) > 1


def test_a_huge_picture_is_refused_as_png_and_written_as_svg(tmp_path: Path) -> None:
    huge = Picture(100_000, 100_000, ())
    with pytest.raises(
        VividcError, match=r"a\.png: a picture of .* is too large for PNG\nhint: write it as SVG"
    ):
        encode(huge, tmp_path / "a.png")
    assert encode(huge, tmp_path / "a.svg").startswith(b"<svg")


def test_another_ending_is_refused() -> None:
    with pytest.raises(VividcError, match=r"'\.pdf' names no picture format"):
        encode(PICTURE, Path("a.pdf"))


def test_translated_moves_every_shape() -> None:
    for shape in SHAPES:
        assert translated(translated(shape, 3, 4), -3, -4) == shape
        assert translated(shape, 3, 4) != shape


def test_text_width_grows_with_text_and_size() -> None:
    assert 0 < text_width("a", 10) < text_width("ab", 10) < text_width("ab", 20)


def test_colours() -> None:
    assert tint(RED, 1) == RED
    assert tint(RED, 0) == "#ffffff"
    assert readable_on("#000000") == "#ffffff"
    assert readable_on(OKABE_ITO["yellow"]) == "#222222"
