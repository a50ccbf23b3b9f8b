"""Links in pictures: each can be followed from PE to PE, or is a stub where it wraps around."""

from __future__ import annotations

from itertools import combinations, pairwise

import pytest
from fabrics import grid

from vividc.arch import load, load_text
from vividc.arch.draw.grid import HEADER, Grid, Point
from vividc.arch.draw.wires import Wire, wires, wrap_arounds
from vividc.arch.fabric import Fabric

_ODD = """
name: odd
extends: mesh-3x3
topology: none
links:
  extra:
    - {from: [1, 0], to: [1, 2]}
    - {from: [0, 0], to: [2, 2]}
    - {from: [2, 1], to: [0, 0]}
    - {from: [2, 0], to: [0, 2]}
    - {from: [2, 2], to: [0, 2]}
    - {from: [1, 1], to: [0, 0]}
    - {from: [0, 0], to: [1, 1]}
"""
_EXTRA = "extends: mesh-4x4\nlinks: {extra: [{from: [0, 0], to: [0, 3]}]}\n"
_KNIGHT = (
    "extends: mesh-4x5\nlinks: {extra: [{from: [0, 0], to: [1, 4]}, {from: [3, 2], to: [0, 1]}]}"
)


def drawn(fabric: Fabric) -> tuple[Grid, list[Wire]]:
    """All links of the fabric at once."""
    place = Grid(fabric)
    return place, wires(place, wrap_arounds(fabric), fabric.links)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        *(("torus-4x4", 16), ("torus-1x3", 2), ("openedge-4x4", 16), ("torus-2x2", 0)),
        *(("mesh-4x4", 0), ("hycube-4x4", 0), ("king-5x5", 0), ("adres-4x4", 0)),
    ],
)
def test_links_that_wrap_around_are_those_of_a_torus(name: str, count: int) -> None:
    assert len(wrap_arounds(load(name))) == count


@pytest.mark.parametrize("text", [_ODD, _EXTRA, _KNIGHT])
def test_an_irregular_link_wraps_nothing_around(text: str) -> None:
    fabric = load_text(text)
    assert wrap_arounds(fabric) == frozenset()
    assert all(len(wire.runs) == 1 for wire in drawn(fabric)[1])


def test_a_torus_with_a_link_removed_still_wraps_around() -> None:
    text = "extends: torus-4x4\nlinks: {removed: [{from: [0, 0], to: [0, 1]}]}\n"
    assert len(wrap_arounds(load_text(text))) == 15


@pytest.mark.parametrize(
    "fabric",
    [
        *(load_text(_ODD), load_text(_EXTRA), load_text(_KNIGHT), load("adres-4x4")),
        *(load("king-3x3"), load("adres-8x8"), load("adres-11x11"), grid(3, 3)),
    ],
    ids=lambda fabric: f"{fabric.name} {fabric.rows}x{fabric.cols}",
)
def test_a_link_is_a_line_from_pe_to_pe_that_passes_beside_all_others(fabric: Fabric) -> None:
    place, found = drawn(fabric)
    boxes = [_box(place, pe.id) for pe in fabric.pes]
    for wire in found:
        (run,) = wire.runs
        assert _on_border(run[0], boxes[wire.link.src])
        assert _on_border(run[-1], boxes[wire.link.dst])
        assert all(0 < x < place.width and HEADER < y < place.height for x, y in run)
        for begin, end in pairwise(run):
            assert not any(_enters(begin, end, box) for box in boxes), wire.link


def test_long_links_side_by_side_keep_apart() -> None:
    place = Grid(load("adres-4x4"))
    long = [link for link in place.fabric.links if place.span(link) > 1]
    in_rows = [k for k in long if place.fabric.pes[k.src].row == place.fabric.pes[k.dst].row]
    found = wires(place, frozenset(), in_rows)
    lines = [run[2:4] for wire in found for run in wire.runs]
    for one, other in combinations(lines, 2):
        (a, y), (b, _), (c, z), (d, _) = *one, *other
        assert y != z or max(a, b) < min(c, d) or max(c, d) < min(a, b)


def _box(place: Grid, pe: int) -> tuple[float, float, float, float]:
    left, top = place.corner(place.fabric.pes[pe])
    return left, top, left + place.detail.width, top + place.detail.height


def _on_border(point: Point, box: tuple[float, float, float, float]) -> bool:
    left, top, right, bottom = box
    x, y = point
    inside = left - 1e-6 <= x <= right + 1e-6 and top - 1e-6 <= y <= bottom + 1e-6
    return inside and min(x - left, right - x, y - top, bottom - y) < 1e-6


def _enters(begin: Point, end: Point, box: tuple[float, float, float, float]) -> bool:
    left, top, right, bottom = box
    for number in range(1, 50):
        x = begin[0] + number / 50 * (end[0] - begin[0])
        y = begin[1] + number / 50 * (end[1] - begin[1])
        if left + 1e-6 < x < right - 1e-6 and top + 1e-6 < y < bottom - 1e-6:
            return True
    return False
