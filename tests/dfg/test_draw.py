"""Pictures of graphs: every node once, words of this iteration flow down, recurrences in colour."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest

from vividc import dfg
from vividc.dfg import DFG, parse
from vividc.errors import VividcError
from vividc.host.plot import OKABE_ITO, Line, Rect, Text

SUM = parse(
    """dfg "sum"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = const 0x00000000
%4 = fadd %2, %4@1(init=%3)
%5 = live_out "%8" %4
"""
)
CARRIED = OKABE_ITO["vermilion"]


def boxes(graph: DFG) -> dict[str, Rect]:
    shapes = graph.plot().shapes
    return {shape.title: shape for shape in shapes if isinstance(shape, Rect)}


def test_every_node_is_a_box_and_words_flow_down() -> None:
    found = boxes(SUM)
    assert len(found) == len(SUM.nodes)
    by_id = {int(title.split(":")[0]): box for title, box in found.items()}
    for edge in SUM.edges:
        if not edge.distance:
            assert by_id[edge.src].y < by_id[edge.dst].y
    rows: dict[float, list[Rect]] = {}
    for box in found.values():
        rows.setdefault(box.y, []).append(box)
    for row in rows.values():
        row.sort(key=lambda box: box.x)
        assert all(a.x + a.width <= b.x for a, b in pairwise(row))


def test_a_recurrence_has_its_distance_and_its_first_word() -> None:
    shapes = SUM.plot().shapes
    lines = [s for s in shapes if isinstance(s, Line) and s.stroke == CARRIED]
    assert len(lines) == 2  # the recurrence, and what its first iteration reads
    assert [s.text for s in shapes if isinstance(s, Text) and s.fill == CARRIED] == ["1"]


def test_everything_is_on_the_canvas() -> None:
    for path in sorted((Path(__file__).parents[1] / "data").rglob("*.json"))[:8]:
        picture = dfg.load(path).plot()
        for shape in picture.shapes:
            if isinstance(shape, Rect):
                assert shape.x >= 0
                assert shape.x + shape.width <= picture.width
                assert shape.y + shape.height <= picture.height


def test_files_and_notebooks(tmp_path: Path) -> None:
    SUM.plot(tmp_path / "sum.svg")
    assert (tmp_path / "sum.svg").read_text() == SUM._repr_svg_()
    assert ElementTree.fromstring(SUM._repr_svg_()).tag.endswith("svg")
    SUM.plot(tmp_path / "sum.png")
    assert (tmp_path / "sum.png").read_bytes().startswith(b"\x89PNG")
    assert SUM.plot()._repr_svg_() == SUM._repr_svg_()
    with pytest.raises(VividcError, match="names no picture format"):
        SUM.plot(tmp_path / "sum.txt")


def test_an_empty_graph_has_a_picture() -> None:
    assert DFG("nothing", (), ()).plot().width > 0
