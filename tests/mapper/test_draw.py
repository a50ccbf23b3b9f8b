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
from vividc.dfg.ir import DFG
from vividc.errors import VividcError
from vividc.host.plot import Line, Rect, Text, readable_on, text_width, to_svg
from vividc.machine.opcodes import Opcode
from vividc.mapper import Mapping, Place, Step, Subject, map_dfg
from vividc.mapper.report.draw.draw import draw
from vividc.mapper.report.draw.scene import colour_of, pale, scene_of

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


def test_an_irregular_link_is_one_arrow_from_pe_to_pe() -> None:
    dfg, fabric = chain(2), grid(3, 3, links=False)
    across = replace(fabric, links=(Link(0, 3, 5),))
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    places = {first: Place(3, 0), second: Place(5, 1)}
    mapping = Mapping(2, places, {index: (Step("link", 5, 0, 1),)})
    arrows = [s for s in draw(dfg, across, mapping).shapes if isinstance(s, Line) and s.arrow]
    assert len(arrows) == 2  # and one in the legend


def test_the_number_of_a_pe_can_be_read_on_its_colour() -> None:
    dfg = chain(1)
    node = dfg.placed[0]
    shapes = draw(dfg, FABRIC, Mapping(1, {node.id: Place(3, 0)}, {})).shapes
    (number,) = [s for s in shapes if isinstance(s, Text) and s.text == "3"]
    assert number.fill == readable_on(colour_of(node))


def test_the_legend_says_what_names_of_rotating_registers_mean() -> None:
    dfg = chain(2)
    index, _ = next(dfg.routed_edges())
    first, second = (node.id for node in dfg.placed[:2])
    places = {first: Place(0, 0), second: Place(0, 5)}
    steps = tuple(Step("reg", 0, 0, time) for time in range(1, 6))
    mapping = Mapping(2, places, {index: steps})
    still = scene_of(dfg, FABRIC, replace(mapping, ii=8))
    assert "5 of 64 register slots" in still.usage()
    turning = replace(FABRIC, pes=tuple(replace(pe, rotating=True) for pe in FABRIC.pes))
    assert "5 of 16 register slots" in scene_of(dfg, turning, mapping).usage()
    shown = [s.text for s in draw(dfg, turning, mapping).shapes if isinstance(s, Text)]
    assert any("its name when the word's iteration began" in text for text in shown)
    plain = [s.text for s in draw(dfg, FABRIC, mapping).shapes if isinstance(s, Text)]
    assert not any("iteration began" in text for text in plain)


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


@pytest.mark.parametrize("size", [2, 8, 11])
def test_long_names_and_ids_are_shortened_to_their_boxes(size: int) -> None:
    short, fabric = chain(3), grid(size, size)
    great = {node.id: 10**30 + node.id for node in short.nodes}
    nodes = tuple(replace(node, id=great[node.id]) for node in short.nodes)
    foreign = tuple(
        replace(node, op=Opcode.GENERIC, name="a_very_long\noperation_name") if n % 2 else node
        for n, node in enumerate(nodes)
    )
    edges = tuple(replace(e, src=great[e.src], dst=great[e.dst]) for e in short.edges)
    long = DFG("x" * 300, foreign, edges)
    index, edge = next(long.routed_edges())
    steps = (Step("link", 1, 0, 1), Step("reg", 1, 0, 2))
    places = {node.id: Place(n % 2, n) for n, node in enumerate(long.placed)}
    picture = draw(long, fabric, Mapping(3, places, {index: steps}))
    boxes = [s for s in picture.shapes if isinstance(s, Rect)]
    labels = [s for s in picture.shapes if isinstance(s, Text) and "…" in s.text]
    labels = [label for label in labels if not label.text.startswith("xxx")]  # the title
    assert any(str(edge.src)[-1] in label.text for label in labels)
    for label in labels:
        width = text_width(label.text, label.size)
        left = label.x - {"start": 0, "middle": 0.5, "end": 1}[label.anchor] * width
        assert any(
            box.x - 1 <= left
            and left + width <= box.x + box.width + 1
            and box.y <= label.y <= box.y + box.height
            for box in boxes
            if box.width < 100
        )


def test_a_long_name_does_not_stretch_the_picture() -> None:
    dfg, mapping = chain(2), Mapping(1, {}, {})
    long = draw(replace(dfg, name="x" * 300), replace(FABRIC, name="y" * 300), mapping)
    assert long.width == draw(dfg, FABRIC, mapping).width
    (title,) = [s for s in long.shapes if isinstance(s, Text) and "II 1" in s.text]
    assert title.text.count("…") == 2
    assert title.x + text_width(title.text, title.size) <= long.width


def test_the_legend_lies_on_a_narrow_picture() -> None:
    dfg = chain(2)
    index, _ = next(dfg.routed_edges())
    link = FABRIC.links[0]
    first, second = (node.id for node in dfg.placed[:2])
    steps = (Step("link", link.dst, link.id, 1), Step("reg", link.dst, 0, 2))
    places = {first: Place(link.src, 0), second: Place(link.dst, 2)}
    picture = draw(dfg, FABRIC, Mapping(1, places, {index: steps}))
    (held,) = [s for s in picture.shapes if isinstance(s, Text) and "in a register" in s.text]
    assert held.x + text_width(held.text, held.size) <= picture.width


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


@settings(max_examples=25)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 40)), min_size=6, max_size=6))
def test_any_places_can_be_drawn(places: list[tuple[int, int]]) -> None:
    dfg = chain(6)
    spots = {node.id: Place(*place) for node, place in zip(dfg.placed, places, strict=False)}
    ElementTree.fromstring(to_svg(draw(dfg, FABRIC, Mapping(3, spots, {}))))
