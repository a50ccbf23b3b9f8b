"""The roofline of a run: operations a cycle over operations a byte (Williams et al. 2009)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.host.plot import OKABE_ITO, Circle, Line, Picture, Rect, Shape, Text, text_width, tint
from vividc.machine.opcodes import MEMORY
from vividc.program import WORD_BYTES, Program
from vividc.sim.stats import RegionStats, Stats

_MEMORY: Final = frozenset(op.value for op in MEMORY)
_LEFT: Final = 64.0
_TOP: Final = 48.0
_WIDTH: Final = 460.0
_HEIGHT: Final = 300.0
_LEGEND: Final = 220.0
_FONT: Final = 9.0
_LABEL_AT: Final = 0.75
_LEAST_SHARE: Final = 0.01
_MOST_POINTS: Final = 12
_COLOURS: Final = ("vermilion", "blue", "green", "purple", "orange", "sky", "grey")


@dataclass(frozen=True, slots=True)
class Point:
    """Something that ran: its operations, the bytes that it moved, and its cycles."""

    name: str
    operations: int
    bytes: int
    cycles: int

    @property
    def intensity(self) -> float:
        """Operations per byte; infinite without bytes."""
        return self.operations / self.bytes if self.bytes else math.inf

    @property
    def rate(self) -> float:
        """Operations per cycle."""
        return self.operations / self.cycles if self.cycles else 0.0


@dataclass(frozen=True, slots=True)
class Roof:
    """A level of memory and its bandwidth in bytes a cycle."""

    name: str
    bytes_per_cycle: float


def tile_roof(program: Program) -> Roof:
    """The scratchpad's: a word a cycle for each bank or load/store unit, whichever are fewer."""
    units = sum(pe.has_memory for pe in program.fabric.pes)
    return Roof("scratchpad", WORD_BYTES * min(units, program.fabric.scratchpad.banks))


def tile_points(stats: Stats, name: str) -> list[Point]:
    """The run, and its regions that take a hundredth of its cycles or more, longest first.

    Loads and stores are no operations: they are what the bytes stand for.
    """
    points = [_point(name, stats)]
    regions = sorted(stats["regions"], key=lambda region: -region["cycles"])
    long = [r for r in regions if r["cycles"] >= _LEAST_SHARE * stats["cycles"] and r["cycles"]]
    return points + [_point(region["name"], region) for region in long[: _MOST_POINTS - 1]]


def roof_above(point: Point, peak: float, roofs: Sequence[Roof]) -> tuple[str, float]:
    """The lowest roof over a point, "compute" or a memory's name, and its operations a cycle."""
    heights = [("compute", peak)]
    heights += [(roof.name, point.intensity * roof.bytes_per_cycle) for roof in roofs]
    return min(heights, key=lambda height: height[1])


def roofline(points: Sequence[Point], peak: float, roofs: Sequence[Roof], title: str) -> Picture:
    """The picture, with logarithmic axes.

    Parameters
    ----------
    peak
        Operations a cycle that the FUs can issue.
    """
    chart = _Chart.around(points, peak, roofs)
    shapes = [
        Text(16, 18, title, 12, bold=True),
        *chart.grid(),
        *chart.roofs(peak, roofs),
        *chart.points(points),
        *_legend(points, peak, roofs),
    ]
    width = _LEFT + _WIDTH + _LEGEND + 24
    height = max(_TOP + _HEIGHT + 52, _TOP + 34.0 * len(points) + 20)
    return Picture(width, height, tuple(shapes), title)


def _point(name: str, stats: Stats | RegionStats) -> Point:
    operations = sum(n for op, n in stats["operations"].items() if op not in _MEMORY)
    moved = stats["bytes"]["scratchpad_read"] + stats["bytes"]["scratchpad_written"]
    return Point(name, operations, moved, stats["cycles"])


@dataclass(frozen=True, slots=True)
class _Chart:
    """Axes in powers of two: the exponents at their ends."""

    left: int
    right: int
    bottom: int
    top: int

    @staticmethod
    def around(points: Sequence[Point], peak: float, roofs: Sequence[Roof]) -> _Chart:
        """Axes that show all points, and where each roof meets the peak."""
        knees = [peak / roof.bytes_per_cycle for roof in roofs]
        xs = [p.intensity for p in points if 0 < p.intensity < math.inf] + knees
        ys = [p.rate for p in points if p.rate > 0] + [peak]
        left, right = (math.log2(end) for end in (min(xs, default=1), max(xs, default=1)))
        bottom, top = math.log2(min(ys)), math.log2(max(ys))
        return _Chart(
            math.floor(left) - 2, math.ceil(right) + 2, math.floor(bottom) - 1, math.ceil(top) + 1
        )

    def x(self, value: float) -> float:
        """Place of an intensity; infinity is at the right edge, nothing at the left one."""
        exponent = self.right if value == math.inf else math.log2(max(value, 2.0**self.left))
        return _LEFT + _WIDTH * (exponent - self.left) / (self.right - self.left)

    def y(self, value: float) -> float:
        """Place of a rate."""
        exponent = math.log2(max(value, 2.0**self.bottom))
        return _TOP + _HEIGHT * (self.top - exponent) / (self.top - self.bottom)

    def grid(self) -> Iterator[Shape]:
        """Axes, their lines and labels."""
        faint = tint("#222222", 0.12)
        bottom = _TOP + _HEIGHT
        for exponent in _ticks(self.left, self.right):
            x = self.x(2.0**exponent)
            yield Line(((x, _TOP), (x, bottom)), faint, 0.6)
            yield Text(x, bottom + 12, _power(exponent), _FONT, "middle")
        for exponent in _ticks(self.bottom, self.top):
            y = self.y(2.0**exponent)
            yield Line(((_LEFT, y), (_LEFT + _WIDTH, y)), faint, 0.6)
            yield Text(_LEFT - 6, y, _power(exponent), _FONT, "end")
        yield Rect(_LEFT, _TOP, _WIDTH, _HEIGHT, None, tint("#222222", 0.6), 0.8)
        middle = _LEFT + _WIDTH / 2
        yield Text(middle, bottom + 30, "operations per byte", _FONT, "middle")
        yield Text(16, _TOP - 12, "operations per cycle", _FONT)

    def roofs(self, peak: float, roofs: Sequence[Roof]) -> Iterator[Shape]:
        """The peak, and a slope for each memory."""
        right = 2.0**self.right
        knees = [peak / roof.bytes_per_cycle for roof in roofs]
        start = min(knees, default=2.0**self.left)
        ends = ((self.x(start), self.y(peak)), (self.x(right), self.y(peak)))
        yield Line(ends, stroke_width=1.6)
        label = f"{peak:g} operations a cycle"
        yield Text(self.x(right) - 6, self.y(peak) - 8, label, _FONT, "end")
        for roof, knee in zip(roofs, knees, strict=True):
            low = max(2.0**self.left, 2.0**self.bottom / roof.bytes_per_cycle)
            foot = (self.x(low), self.y(low * roof.bytes_per_cycle))
            yield Line((foot, (self.x(knee), self.y(peak))), stroke_width=1.6)
            text = f"{roof.name}: {roof.bytes_per_cycle:g} bytes a cycle"
            at = low * (knee / low) ** _LABEL_AT
            # Above the slope: points lie below it.
            place = (self.x(at) - 8, self.y(at * roof.bytes_per_cycle) - 6)
            yield Text(*place, text, _FONT, "end")

    def points(self, points: Sequence[Point]) -> Iterator[Shape]:
        """A disc each; the first is the largest."""
        for number, point in reversed(list(enumerate(points))):
            if point.rate > 0:
                radius = 6.0 if number == 0 else 4.0
                place = (self.x(point.intensity), self.y(point.rate))
                yield Circle(*place, radius, _colour(number), stroke_width=0.6)


def _legend(points: Sequence[Point], peak: float, roofs: Sequence[Roof]) -> Iterator[Shape]:
    x, y = _LEFT + _WIDTH + 20, _TOP + 6
    for number, point in enumerate(points):
        name, height = roof_above(point, peak, roofs)
        share = 100 * point.rate / height if height else 0.0
        yield Circle(x, y, 4, _colour(number), stroke_width=0.6)
        yield Text(x + 10, y, _fitted(point.name), _FONT, bold=number == 0)
        text = f"{point.rate:.2f} a cycle: {share:.0f} % of the {name} roof"
        yield Text(x + 10, y + 12, text, _FONT)
        y += 34


def _fitted(name: str) -> str:
    while text_width(name, _FONT) > _LEGEND - 20:
        name = name[:-2].rstrip(".") + "."
    return name


def _ticks(first: int, last: int) -> range:
    return range(first, last + 1, max(1, (last - first) // 8))


def _power(exponent: int) -> str:
    return str(2**exponent) if exponent >= 0 else f"1/{2**-exponent}"


def _colour(number: int) -> str:
    return OKABE_ITO[_COLOURS[number % len(_COLOURS)]]
