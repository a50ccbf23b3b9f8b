"""Heat maps and rooflines show what they should, where they should."""

import math

import pytest

from tests.sim.view.test_recording import X, strided_arguments
from vividc.host.plot import Circle, Picture, Rect, Text, to_png, to_svg
from vividc.sim.run import simulate
from vividc.sim.view import (
    Point,
    Roof,
    heat_map,
    record,
    roof_above,
    roofline,
    tile_points,
    tile_roof,
)


def inside(picture: Picture):
    for shape in picture.shapes:
        if isinstance(shape, Rect):
            assert shape.x >= 0
            assert shape.x + shape.width <= picture.width + 1e-6
            assert shape.y + shape.height <= picture.height + 1e-6
        if isinstance(shape, Text | Circle):
            assert 0 <= shape.x <= picture.width
            assert 0 <= shape.y <= picture.height


def test_heat_map(programs):
    recording = record(programs["strided"], strided_arguments(), {}, words=False)
    picture = heat_map(recording)
    inside(picture)
    texts = {shape.text for shape in picture.shapes if isinstance(shape, Text)}
    assert {f"PE {pe}" for pe in range(16)} <= texts
    tips = [shape.title for shape in picture.shapes if isinstance(shape, Rect) and shape.title]
    used = {one.pe for issued in recording.issued for one in issued}
    assert {int(tip.split()[1][:-1]) for tip in tips if tip.startswith("PE ")} == used
    assert to_svg(picture).startswith("<svg") or "<svg" in to_svg(picture)
    assert to_png(picture).startswith(b"\x89PNG")


def test_points_of_a_run_count_words_and_leave_loads_out(programs):
    """`found += x[i]`, 40 times: 40 loads of a word, and the loop adds once an iteration."""
    stats = simulate(programs["total"], X, 40).stats
    whole, *regions = tile_points(stats, "total")
    assert whole.bytes == 4 * 40
    loads = stats["operations"]["load"]
    assert whole.operations == sum(stats["operations"].values()) - loads
    assert loads == 40
    loop = max(regions, key=lambda point: point.cycles)
    assert loop.operations >= 40
    assert loop.intensity == loop.operations / 160


def test_the_roof_of_a_tile(programs):
    """Seven load/store units, eight banks: seven words a cycle."""
    assert tile_roof(programs["total"]) == Roof("scratchpad", 28)


@pytest.mark.parametrize(
    ("operations", "size", "expected"),
    [(10, 10, ("scratchpad", 8.0)), (80, 10, ("compute", 16.0)), (5, 0, ("compute", 16.0))],
)
def test_the_roof_above_a_point(operations, size, expected):
    point = Point("p", operations, size, 10)
    assert roof_above(point, 16.0, [Roof("scratchpad", 8)]) == expected


def test_roofline(programs):
    points = [Point("all", 100, 40, 50), Point("no bytes", 10, 0, 10), Point("idle", 0, 40, 9)]
    picture = roofline(points, 16, [Roof("scratchpad", 28), Roof("dram", 2)], "title")
    inside(picture)
    discs = [s for s in picture.shapes if isinstance(s, Circle)]
    assert len(discs) == 2 + 3  # of the points that did something, and the legend's
    texts = " ".join(shape.text for shape in picture.shapes if isinstance(shape, Text))
    assert "2.00 a cycle: 40 % of the dram roof" in texts
    assert "28 bytes a cycle" in texts
    assert to_png(picture).startswith(b"\x89PNG")


def test_a_run_of_nothing_has_a_roofline(programs):
    stats = simulate(programs["total"], X, 0).stats
    points = tile_points(stats, "total")
    assert points[0].intensity == math.inf
    inside(roofline(points, 16, [tile_roof(programs["total"])], "t"))
