"""Arrow heads: where they lie, the same in every format."""

from __future__ import annotations

import math

from vividc.host.plot.picture import Line

_LENGTH = 4.0
_HALF_WIDTH = 1.8


def shaft(line: Line) -> tuple[tuple[float, float], ...]:
    """The points of the line itself: with an arrow it ends inside the head, not at its tip."""
    if not line.arrow:
        return line.points
    (x0, y0), (x1, y1) = line.points[-2:]
    length = math.hypot(x1 - x0, y1 - y0) or 1.0
    back = min(0.8 * _LENGTH * _scale(line), length) / length
    return (*line.points[:-1], (x1 - back * (x1 - x0), y1 - back * (y1 - y0)))


def arrow_head(line: Line) -> tuple[tuple[float, float], ...]:
    """The triangle at the end of the line."""
    (x0, y0), (x1, y1) = line.points[-2:]
    length = math.hypot(x1 - x0, y1 - y0) or 1.0
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    back, side = _LENGTH * _scale(line), _HALF_WIDTH * _scale(line)
    foot_x, foot_y = x1 - back * ux, y1 - back * uy
    left = (foot_x - side * uy, foot_y + side * ux)
    right = (foot_x + side * uy, foot_y - side * ux)
    return ((x1, y1), left, right)


def _scale(line: Line) -> float:
    return max(1.0, line.stroke_width)
