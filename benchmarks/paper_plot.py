"""Pictures of Figure 1(b) and Figure 7(c): a bar a method, cut into stages or into what gave the
speed-up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from vividc.host.files import write_whole
from vividc.host.plot import (
    OKABE_ITO,
    Picture,
    Rect,
    Shape,
    Text,
    encode,
    readable_on,
    text_width,
    tint,
)

_LEFT, _TOP, _WIDTH, _BAR, _PITCH = 90.0, 40.0, 560.0, 26.0, 40.0
_RIGHT: Final = 110.0
_LEGEND_ROW: Final = 18.0
_SWATCH: Final = 10.0
_SIZE: Final = 10.0
_STRENGTHS: Final = (1.0, 0.55, 0.25)
"""Of colours, when there are more parts than colours."""

Bars = Mapping[str, Mapping[str, float]]
"""Size of each part, by bar."""


def draw_stages(path: Path, bars: Bars) -> None:
    """Write the cycles of each stage by method, as shares of the frame.

    Raises
    ------
    VividcError
        The path's ending names no picture format.
    """
    totals = {name: sum(parts.values()) for name, parts in bars.items()}
    ends = {name: f"{total / 1e6:.1f} M cycles" for name, total in totals.items()}
    parts = [
        {
            stage: (cycles / totals[name], f"{cycles / totals[name]:.0%}")
            for stage, cycles in cut.items()
        }
        for name, cut in bars.items()
    ]
    title = "Cycles of a frame by stage, float32 with lookahead"
    _write(path, _stacked(title, list(bars), parts, list(ends.values())))


def draw_contributions(path: Path, bars: Bars) -> None:
    """Write what each step contributes to the speed-up: the logarithm of its factor, as a share.

    Steps that slow down have no part of the bar.

    Raises
    ------
    VividcError
        The path's ending names no picture format.
    """
    parts, ends = [], []
    for factors in bars.values():
        gains = {step: math.log(factor) for step, factor in factors.items() if factor > 1}
        whole = sum(gains.values())
        parts.append({step: (g / whole, f"{factors[step]:.2f}x") for step, g in gains.items()})
        ends.append(f"{math.prod(factors.values()):.2f}x in all")
    title = "What gives the speed-up over float32 in GPU-like mode without culling"
    _write(path, _stacked(title, list(bars), parts, ends))


def _stacked(
    title: str,
    names: Sequence[str],
    bars: Sequence[Mapping[str, tuple[float, str]]],
    ends: Sequence[str],
) -> Picture:
    """Return bars one below the other; each part has its share of the width, and a label."""
    fills = _fills(list(dict.fromkeys(part for bar in bars for part in bar)))
    shapes: list[Shape] = [Text(_LEFT, 18, title, size=12, bold=True)]
    for row, (name, bar, end) in enumerate(zip(names, bars, ends, strict=True)):
        y = _TOP + _PITCH * row
        middle = y + _BAR / 2
        shapes.append(Text(_LEFT - 8, middle, name, anchor="end"))
        x = _LEFT
        for part, (share, label) in bar.items():
            width = share * _WIDTH
            title = f"{part}: {label}"
            shapes.append(Rect(x, y, width, _BAR, fill=fills[part], stroke_width=0.5, title=title))
            if text_width(label, _SIZE) + 4 < width:
                ink = readable_on(fills[part])
                at = x + width / 2
                shapes.append(Text(at, middle, label, size=_SIZE, anchor="middle", fill=ink))
            x += width
        shapes.append(Text(_LEFT + _WIDTH + 8, middle, end))
    top = _TOP + _PITCH * len(names) + 8
    legend = list(_legend(fills, top))
    height = max((shape.y for shape in legend), default=top) + 24
    return Picture(_LEFT + _WIDTH + _RIGHT, height, (*shapes, *legend))


def _fills(parts: Sequence[str]) -> dict[str, str]:
    colours = [tint(colour, by) for by in _STRENGTHS for colour in OKABE_ITO.values()]
    return {part: colours[number % len(colours)] for number, part in enumerate(parts)}


def _legend(fills: Mapping[str, str], top: float) -> Iterator[Rect | Text]:
    x, y = _LEFT, top
    for name, fill in fills.items():
        width = _SWATCH + 6 + text_width(name, _SIZE) + 16
        if x + width > _LEFT + _WIDTH + _RIGHT and x > _LEFT:
            x, y = _LEFT, y + _LEGEND_ROW
        yield Rect(x, y, _SWATCH, _SWATCH, fill=fill, stroke_width=0.5)
        yield Text(x + _SWATCH + 6, y + _SWATCH / 2, name, size=_SIZE)
        x += width


def _write(path: Path, picture: Picture) -> None:
    write_whole(path, encode(picture, path))
