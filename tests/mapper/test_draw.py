"""Pictures of mappings: everything that happens is on them, and nothing overlaps the frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from fabrics import grid
from graphs import accumulator, chain
from hypothesis import given, settings
from hypothesis import strategies as st

from vividc.arch import load
from vividc.arch.fabric import Link
from vividc.errors import VividcError
from vividc.mapper import Mapping, Place, Step, Subject, map_dfg
from vividc.mapper.draw import draw
from vividc.mapper.draw_scene import pale
from vividc.plot import Line, Rect, Text, text_width, to_svg

FABRIC = grid(2, 2)


def texts(mapping: Mapping) -> list[str]:
    return [shape.text for shape in mapping.plot().shapes if isinstance(shape, Text)]


def test_operations_slots_and_usage_are_named() -> None:
    result = map_dfg(chain(5), FABRIC, workers=1)
    assert result.mapping is not None
    shown = texts(result.mapping)
    assert any(text.startswith(f"{chain(5).name} on {FABRIC.name}: II 2") for text in shown)
    assert {"slot 0", "slot 1"} <= set(shown)
    for node in chain(5).operations:
        assert any(f"{node.op.value} {node.id}" in text for text in shown)


def test_every_driven_link_is_an_arrow_with_its_producer() -> None:
    mapping = map_dfg(chain(5), FABRIC, workers=1).mapping
    assert mapping is not None
    driven = {
        (step.index, (step.time - 1) % mapping.ii)
        for steps in mapping.routes.values()
        for step in steps
        if step.kind == "link"
    }
    arrows = [s for s in mapping.plot().shapes if isinstance(s, Line) and s.arrow]
    assert len(arrows) == len(driven) + 1  # and one in the legend


def test_a_word_in_a_register_is_a_chip() -> None:
    dfg = chain(2)
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    steps = (Step("reg", 0, 3, 1), Step("reg", 0, 3, 2))
    places = {first: Place(0, 0), second: Place(0, 2)}
    mapping = Mapping(4, places, {index: steps}, Subject(dfg, FABRIC))
    assert texts(mapping).count(f"r3:{first}") == 2


def test_moves_and_outputs_are_shown() -> None:
    fabric = load("openedge-2x2")
    dfg = chain(2)
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    steps = (Step("out", 0, 0, 1), Step("out", 1, 0, 2), Step("out", 1, 0, 3))
    places = {first: Place(0, 0), second: Place(1, 3)}
    shown = texts(Mapping(4, places, {index: steps}, Subject(dfg, fabric)))
    assert shown.count(f"mov {first}") == 2  # in slot 1 of PE 1, and in the table
    assert shown.count(f"o:{first}") == 3
    assert "word moved by an FU" in shown
    assert any(text.startswith("3 of 16 FU slots") for text in shown)


def test_an_fu_that_is_kept_busy_is_tinted() -> None:
    dfg = chain(1)
    node = dfg.placed[0]
    slow = replace(FABRIC, occupancies={node.latency_class: 3})
    picture = draw(dfg, slow, Mapping(4, {node.id: Place(0, 3)}, {}))
    tinted = [s for s in picture.shapes if isinstance(s, Rect) and s.fill == pale(node)]
    assert len(tinted) == 4  # slots 0 and 1, in the array and in the table


def test_a_link_that_wraps_around_is_two_stubs() -> None:
    dfg, fabric = chain(2), grid(1, 3)
    wrap = Link(len(fabric.links), 2, 0)
    torus = replace(fabric, links=(*fabric.links, wrap))
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    places = {first: Place(2, 0), second: Place(0, 1)}
    mapping = Mapping(2, places, {index: (Step("link", 0, wrap.id, 1),)})
    arrows = [s for s in draw(dfg, torus, mapping).shapes if isinstance(s, Line) and s.arrow]
    assert len(arrows) == 3


@pytest.mark.parametrize(("rows", "cols", "ii"), [(1, 1, 1), (4, 4, 5), (8, 8, 2), (16, 16, 3)])
def test_every_shape_lies_on_the_canvas(rows: int, cols: int, ii: int) -> None:
    fabric, dfg = grid(rows, cols), chain(6)
    places = {
        node.id: Place(7 * number % len(fabric.pes), number)
        for number, node in enumerate(dfg.placed)
    }
    steps = {i: (Step("link", 0, i % max(len(fabric.links), 1), i + 1),) for i in range(3)}
    picture = draw(dfg, fabric, Mapping(ii, places, steps if fabric.links else {}))
    for shape in picture.shapes:
        if isinstance(shape, Rect):
            right, bottom = shape.x + shape.width, shape.y + shape.height
            assert shape.x >= 0
            assert shape.y >= 0
            assert (right <= picture.width, bottom <= picture.height) == (True, True)
        if isinstance(shape, Text) and shape.anchor == "start":
            assert shape.x + text_width(shape.text, shape.size) <= picture.width


def test_long_names_are_shortened_to_their_box() -> None:
    dfg = chain(1)
    node = replace(dfg.placed[0], op=dfg.placed[0].op, id=123456789)
    long = replace(dfg, nodes=tuple(node if n is dfg.placed[0] else n for n in dfg.nodes), edges=())
    picture = draw(long, FABRIC, Mapping(1, {node.id: Place(0, 0)}, {}))
    for shape in picture.shapes:
        if isinstance(shape, Text) and shape.anchor == "middle":
            assert text_width(shape.text, shape.size) < 90


def test_the_file_is_svg_or_png_by_its_ending(tmp_path: Path) -> None:
    mapping = map_dfg(accumulator(), FABRIC, workers=1).mapping
    assert mapping is not None
    mapping.plot(tmp_path / "a.svg")
    mapping.plot(tmp_path / "a.png")
    ElementTree.parse(tmp_path / "a.svg")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(VividcError, match="names no picture format"):
        mapping.plot(tmp_path / "a.gif")
    with pytest.raises(VividcError, match="cannot be written"):
        mapping.plot(tmp_path / "none" / "a.svg")


def test_a_mapping_without_its_graph_asks_for_it() -> None:
    with pytest.raises(VividcError, match="does not know its graph"):
        Mapping(1, {}, {}).plot()


@pytest.mark.parametrize(
    ("mapping", "what"),
    [
        (Mapping(1, {99: Place(0, 0)}, {}), "node 99"),
        (Mapping(1, {1: Place(44, 0)}, {}), "PE 44"),
        (Mapping(1, {}, {77: ()}), "edge 77"),
        (Mapping(1, {}, {0: (Step("link", 0, 500, 1),)}), "link 500"),
        (Mapping(0, {}, {}), "II 0"),
    ],
)
def test_a_mapping_of_something_else_is_refused(mapping: Mapping, what: str) -> None:
    with pytest.raises(VividcError, match=f"names {what}, which"):
        draw(chain(3), FABRIC, mapping)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 40)), min_size=6, max_size=6))
def test_any_places_can_be_drawn(places: list[tuple[int, int]]) -> None:
    dfg = chain(6)
    spots = {node.id: Place(*place) for node, place in zip(dfg.placed, places, strict=False)}
    ElementTree.fromstring(to_svg(draw(dfg, FABRIC, Mapping(3, spots, {}))))
