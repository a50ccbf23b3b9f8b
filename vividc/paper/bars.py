"""Bars: one a method cut into parts, as in Figures 1(b) and 7(c), and ours beside theirs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from vividc.host.plot import (
    OKABE_ITO,
    Picture,
    Rect,
    Shape,
    Text,
    readable_on,
    text_width,
    tint,
)
from vividc.paper.exhibit import Theirs

_LEFT, _TOP, _WIDTH, _BAR, _PITCH = 150.0, 40.0, 500.0, 26.0, 40.0
_PAIR: Final = 28.0
_RIGHT: Final = 110.0
_LEGEND_ROW: Final = 18.0
_SWATCH: Final = 10.0
_SIZE: Final = 10.0
_STRENGTHS: Final = (1.0, 0.55, 0.25)
"""Of colours, when there are more parts than colours."""

Bars = Mapping[str, Mapping[str, float]]
"""Size of each part, by bar."""


def stages(bars: Bars, title: str) -> Picture:
    """Return the cycles of each stage by method, as shares of the frame."""
    totals = {name: sum(parts.values()) for name, parts in bars.items()}
    ends = [f"{total / 1e6:.1f} M cycles" for total in totals.values()]
    parts = [
        {
            stage: (cycles / totals[name], f"{cycles / totals[name]:.0%}")
            for stage, cycles in cut.items()
        }
        for name, cut in bars.items()
    ]
    return _stacked(title, list(bars), parts, ends)


def contributions(bars: Bars, title: str) -> Picture:
    """Return what each step contributes to the speed-up: the logarithm of its factor, as a share.

    Steps that slow down have no part of the bar.
    """
    parts, ends = [], []
    for factors in bars.values():
        gains = {step: math.log(factor) for step, factor in factors.items() if factor > 1}
        whole = sum(gains.values())
        parts.append({step: (g / whole, f"{factors[step]:.2f}x") for step, g in gains.items()})
        ends.append(f"{math.prod(factors.values()):.2f}x in all")
    return _stacked(title, list(bars), parts, ends)


def paired(title: str, bars: Sequence[tuple[str, float | None, Theirs]]) -> Picture:
    """Return two bars for each (name, ours, theirs), on one scale; of a range, from end to end."""
    ends = [_ends(theirs) for _, _, theirs in bars]
    most = max((n for pair in ends for n in pair), default=0.0)
    most = max([most, *(ours for _, ours, _ in bars if ours is not None)]) or 1.0
    shapes: list[Shape] = [Text(_LEFT, 18, title, size=12, bold=True)]
    fills = dict(zip(("vividc", "the paper"), OKABE_ITO.values(), strict=False))
    y = _TOP
    for (name, ours, _), (low, high) in zip(bars, ends, strict=True):
        shapes.append(Text(_LEFT - 8, y + _PAIR / 2 + 2, name, anchor="end", size=_SIZE))
        both = (
            ("vividc", 0.0, ours or 0.0, _number(ours)),
            ("the paper", low, high, _range(low, high)),
        )
        for number, (who, first, last, label) in enumerate(both):
            top, x = y + number * _PAIR / 2, _LEFT + _WIDTH * (first if first < last else 0) / most
            width = _LEFT + _WIDTH * last / most - x
            shapes.append(Rect(x, top, width, _PAIR / 2 - 1, fill=fills[who], stroke=None))
            shapes.append(Text(x + width + 6, top + _PAIR / 4, label, size=_SIZE))
        y += _PAIR + 10
    return Picture(_LEFT + _WIDTH + _RIGHT, y + 24, (*shapes, *_legend(fills, y + 4)))


def _ends(theirs: Theirs) -> tuple[float, float]:
    if theirs is None:
        return 0.0, 0.0
    return theirs if isinstance(theirs, tuple) else (theirs, theirs)


def _range(low: float, high: float) -> str:
    return _number(high) if low == high else f"{low:g} to {high:g}"


def _number(value: float | None) -> str:
    return "-" if value is None or value == 0 else f"{value:.3g}"


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
