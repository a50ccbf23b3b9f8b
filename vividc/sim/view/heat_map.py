"""How busy each PE was in each cycle of a recording, as a picture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.host.plot import OKABE_ITO, PAPER, Line, Picture, Rect, Shape, Text, text_width, tint
from vividc.sim.view.recording import Recording

MOST_COLUMNS: Final = 160
_LEFT: Final = 70.0
_TOP: Final = 92.0
_WIDTH: Final = 640.0
_ROW: Final = 13.0
_STRIP: Final = 10.0
_FONT: Final = 8.5
_LABELS: Final = 8
_MARGIN: Final = 16.0
_BUSY: Final = "blue"
_STALL: Final = "vermilion"
_REGIONS: Final = ("sky", "orange", "green", "purple", "yellow")


def utilization(recording: Recording, columns: int = MOST_COLUMNS) -> NDArray[np.float64]:
    """Issues per cycle: float64 [PEs, bins]; at most `columns` bins, equally long but the last."""
    size = recording.end - recording.first
    width = bin_cycles(recording, columns)
    counts = np.zeros((len(recording.program.fabric.pes), max(1, -(-size // width))), np.float64)
    for cycle, issued in zip(recording.cycles.tolist(), recording.issued, strict=True):
        for one in issued:
            counts[one.pe, (cycle - recording.first) // width] += 1
    return counts / _lengths(size, width)


def bin_cycles(recording: Recording, columns: int = MOST_COLUMNS) -> int:
    """Cycles of a bin."""
    return max(1, -(-(recording.end - recording.first) // columns))


def heat_map(recording: Recording) -> Picture:
    """Rows are PEs, columns cycles, or bins of cycles where there are more than fit; the darker the
    busier. Above them: which region ran, and the share of cycles in which the tile stood still.
    """
    shares = utilization(recording)
    pes, bins = shares.shape
    cell = _WIDTH / bins
    bottom = _TOP + pes * _ROW
    name = recording.program.name
    title = f"{name}: PEs in use, cycles {recording.first} to {recording.end - 1}"
    shapes: list[Shape] = [
        Text(_MARGIN, 16, title, 12, bold=True),
        Text(_MARGIN, 32, _subtitle(recording, shares), _FONT),
        *_legend(recording),
        *_strips(recording, cell),
    ]
    for pe in range(pes):
        y = _TOP + pe * _ROW
        shapes.append(Text(_LEFT - 6, y + _ROW / 2, f"PE {pe}", _FONT, "end"))
        shapes += _row(shares[pe], y, cell, pe)
    shapes.append(Rect(_LEFT, _TOP, _WIDTH, pes * _ROW, None, tint("#222222", 0.4), 0.5))
    shapes += _axis(recording, cell, bottom)
    return Picture(_LEFT + _WIDTH + 24, bottom + 46, tuple(shapes), title)


def _subtitle(recording: Recording, shares: NDArray[np.float64]) -> str:
    width = bin_cycles(recording)
    busy = sum(map(len, recording.issued)) / max(1, shares.shape[0] * _size(recording))
    each = "a column is a cycle" if width == 1 else f"a column is {width} cycles"
    stopped = "" if recording.stopped is None else "; stopped by an error at the end"
    return f"{each}; on average {100 * busy:.0f} % of the PEs issue{stopped}"


def _size(recording: Recording) -> int:
    return recording.end - recording.first


def _legend(recording: Recording) -> Iterator[Shape]:
    x = _MARGIN
    for share in (0.0, 0.5, 1.0):
        yield Rect(x, 42, 14, 10, _shade(share), tint("#222222", 0.4), 0.5)
        label = f"{100 * share:.0f} %"
        yield Text(x + 18, 47, label, _FONT)
        x += 18 + text_width(label, _FONT) + 10
    yield Rect(x, 42, 14, 10, OKABE_ITO[_STALL], None)
    yield Text(x + 18, 47, "stalled", _FONT)
    x += 18 + text_width("stalled", _FONT) + 16
    for region in sorted(set(recording.regions.tolist())):
        label = recording.program.regions[region].name
        if x + 18 + text_width(label, _FONT) > _LEFT + _WIDTH:
            yield Text(x, 47, "...", _FONT)
            return
        yield Rect(x, 42, 14, 10, _colour(region), None)
        yield Text(x + 18, 47, label, _FONT)
        x += 18 + text_width(label, _FONT) + 10


def _strips(recording: Recording, cell: float) -> Iterator[Shape]:
    """The regions that ran, and the stalls."""
    width = bin_cycles(recording)
    y = _TOP - 2 * _STRIP - 6
    yield Text(_LEFT - 6, y + _STRIP / 2, "region", _FONT, "end")
    for first, end, region in _stretches(recording):
        left, right = (cycle / width * cell for cycle in (first, end))
        tip = recording.program.regions[region].name
        yield Rect(
            _LEFT + left, y, max(0.3, right - left), _STRIP, _colour(region), None, title=tip
        )
    y += _STRIP + 2
    yield Text(_LEFT - 6, y + _STRIP / 2, "stalled", _FONT, "end")
    stalled = recording.stalled()
    edges = range(0, stalled.size, width)
    for number, first in enumerate(edges):
        share = float(stalled[first : first + width].mean())
        if share:
            colour = tint(OKABE_ITO[_STALL], max(0.15, share))
            tip = f"{100 * share:.0f} %"
            yield Rect(_LEFT + number * cell, y, cell, _STRIP, colour, None, title=tip)


def _stretches(recording: Recording) -> Iterator[tuple[int, int, int]]:
    """(first, end, region) of each run of samples of one region, from the window's first cycle."""
    cycles, regions = recording.cycles - recording.first, recording.regions
    if not regions.size:
        return
    changes = np.flatnonzero(np.diff(regions)) + 1
    starts = [0, *changes.tolist()]
    ends = [*changes.tolist(), regions.size]
    for start, end in zip(starts, ends, strict=True):
        yield int(cycles[start]), int(cycles[end - 1]) + 1, int(regions[start])


def _row(shares: NDArray[np.float64], y: float, cell: float, pe: int) -> Iterator[Shape]:
    """One rectangle for each stretch of columns of equal share."""
    values = shares.tolist()
    start = 0
    for column in range(1, len(values) + 1):
        if column < len(values) and values[column] == values[start]:
            continue
        if values[start]:
            tip = f"PE {pe}: {100 * values[start]:.0f} %"
            width = (column - start) * cell
            fill = _shade(values[start])
            yield Rect(_LEFT + start * cell, y, width, _ROW, fill, None, title=tip)
        start = column


def _axis(recording: Recording, cell: float, y: float) -> Iterator[Shape]:
    width = bin_cycles(recording)
    step = _step(_size(recording))
    begin = -(-recording.first // step) * step
    for cycle in range(begin, recording.end + 1, step):
        x = _LEFT + (cycle - recording.first) / width * cell
        yield Line(((x, y), (x, y + 4)), stroke_width=0.7)
        yield Text(x, y + 12, str(cycle), _FONT, "middle")
    yield Text(_LEFT + _WIDTH / 2, y + 28, "cycle", _FONT, "middle")


def _step(size: int) -> int:
    """1, 2 or 5 times a power of ten, so that there are at most eight labels."""
    power = 1
    while True:
        for factor in (1, 2, 5):
            if factor * power * _LABELS >= size:
                return factor * power
        power *= 10


def _lengths(size: int, width: int) -> NDArray[np.float64]:
    """Cycles of each bin."""
    bins = max(1, -(-size // width))
    lengths = np.full(bins, width, np.float64)
    lengths[-1] = max(1, size - (bins - 1) * width)
    return lengths


def _shade(share: float) -> str:
    return PAPER if share <= 0 else tint(OKABE_ITO[_BUSY], 0.1 + 0.9 * min(share, 1.0))


def _colour(region: int) -> str:
    return OKABE_ITO[_REGIONS[region % len(_REGIONS)]]
