"""How links are drawn: straight, round the PEs between, or as two stubs where they wrap around."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

from vividc.arch.draw.grid import Grid, Point
from vividc.arch.fabric import PE, Fabric, Link

Path = tuple[Point, ...]
Way = Literal["row", "column"]

_SIDE: Final = 0.16  # the two directions of a link pair lie this far beside the middle
_STUB: Final = 0.86
_TRACKS: Final = (0.27, 0.73, 0.5, 0.17, 0.83)  # of a channel's breadth
_LABEL: Final = 0.35  # of a gap behind the first bend, clear of them too
_PORTS: Final = (0.74, 0.92, 0.7, 0.96)  # of a PE's border, clear of the links to neighbours
_OPPOSITE: Final = 0.03  # between ports that face each other across a channel
_BEND: Final = 3.0


@dataclass(frozen=True, slots=True)
class Wire:
    """One link: the lines to draw, and the middle of the label of each."""

    link: Link
    runs: tuple[Path, ...]
    labels: tuple[Point, ...]


def wrap_arounds(fabric: Fabric) -> frozenset[int]:
    """Ids of the links that wrap around as on a torus.

    Such a link closes a ring with the links along its row or column, and more than half of the
    rows, or of the columns, have one.
    """
    ids = {(link.src, link.dst): link.id for link in fabric.links}
    pes, cols = range(len(fabric.pes)), fabric.cols
    rows = [pes[first : first + cols] for first in pes[::cols]]
    columns = [pes[col::cols] for col in range(cols)]
    wrapping: set[int] = set()
    for lines in (rows, columns):
        closing = [_closing(line, ids) for line in lines]
        if 2 * sum(map(bool, closing)) > len(lines):
            wrapping.update(*closing)
    return frozenset(wrapping)


def _closing(line: range, ids: Mapping[tuple[int, int], int]) -> list[int]:
    """The links from an end of the line to the other that close a ring with the links on it."""
    closing = []
    for way in (line, line[::-1]):
        ends = (way[-1], way[0])
        between_neighbours = ends in pairwise(line) or ends in pairwise(line[::-1])
        if ends in ids and not between_neighbours and all(pair in ids for pair in pairwise(way)):
            closing.append(ids[ends])
    return closing


def wires(grid: Grid, wrapped: frozenset[int], links: Iterable[Link]) -> list[Wire]:
    """The links of one slot; `wrapped`: which of them wrap around."""
    channels = _Channels(grid)
    pes, drawn = grid.fabric.pes, []
    for link in links:
        src, dst = pes[link.src], pes[link.dst]
        if grid.span(link) <= 1:
            runs: tuple[Path, ...] = (_straight(grid, src, dst),)
        elif link.id in wrapped:
            runs = _stubs(grid, src, dst)
        else:
            path, label = channels.path(src, dst)
            drawn.append(Wire(link, (_bent(path),), (label,)))
            continue
        drawn.append(Wire(link, runs, tuple(map(_label_of, runs))))
    return drawn


def _straight(grid: Grid, src: PE, dst: PE) -> Path:
    rows, cols = dst.row - src.row, dst.col - src.col
    return (_port(grid, src, rows, cols, 1), _port(grid, dst, -rows, -cols, -1))


def _stubs(grid: Grid, src: PE, dst: PE) -> tuple[Path, Path]:
    """One stub leaves the array, the other enters at the opposite border."""
    row, col = _sign(src.row - dst.row), _sign(src.col - dst.col)
    length = _STUB * grid.detail.gap
    begin, end = _port(grid, src, row, col, 1), _port(grid, dst, -row, -col, -1)
    outside = (begin[0] + col * length, begin[1] + row * length)
    return (begin, outside), ((end[0] - col * length, end[1] - row * length), end)


def _port(grid: Grid, pe: PE, row: int, col: int, side: int) -> Point:
    """A point on the PE's border towards (row, col), beside the middle or corner by `side`."""
    d = grid.detail
    left, top = grid.corner(pe)
    beside = side * _SIDE * d.height
    x = d.width * (0.5 + 0.5 * col) - beside * row
    y = d.height * (0.5 + 0.5 * row) + beside * col
    return (left + min(max(x, 0.0), d.width), top + min(max(y, 0.0), d.height))


def _label_of(run: Path) -> Point:
    """Nearer to the begin: labels of the two directions of a pair stay apart, and those of
    diagonals off the crossing.
    """
    (x0, y0), (x1, y1) = run
    at = 0.42 if x0 == x1 or y0 == y1 else 0.25
    return (x0 + at * (x1 - x0), y0 + at * (y1 - y0))


class _Channels:
    """Leads long links through the channels between PEs: each has a track of its own there.

    Channel k of way "row" lies above row k, of way "column" left of column k.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.taken: dict[tuple[Way, int, int], list[tuple[float, float]]] = defaultdict(list)
        self.ports: Counter[tuple[int, Way, bool, bool]] = Counter()

    def path(self, src: PE, dst: PE) -> tuple[Path, Point]:
        """The line from `src` to `dst`, and where its label lies."""
        rows, cols = dst.row - src.row, dst.col - src.col
        if abs(rows) > 1 and abs(cols) > 1:
            return self._through_two(src, dst, rows, cols)
        if abs(cols) > 1:
            return self._through_one("row", src, dst, cols, rows)
        return self._through_one("column", src, dst, rows, cols)

    def _through_one(
        self, way: Way, src: PE, dst: PE, along: int, across: int
    ) -> tuple[Path, Point]:
        """Within a row or column each direction keeps to its right, as links to neighbours do."""
        after = across > 0 or (across == 0 and (along > 0) == (way == "row"))
        channel = (src.row if way == "row" else src.col) + after
        begin = self._port(src, way, after=after, high=along > 0)
        end = self._port(dst, way, after=after == (across == 0), high=along < 0)
        first, last = (begin[0], end[0]) if way == "row" else (begin[1], end[1])
        line = self._track(way, channel, first, last)
        label = _point(way, first + _sign(along) * _LABEL * self.grid.detail.gap, line)
        return (begin, _point(way, first, line), _point(way, last, line), end), label

    def _through_two(self, src: PE, dst: PE, rows: int, cols: int) -> tuple[Path, Point]:
        """Along the row of `src`, then along the column of `dst`."""
        down, left = rows > 0, cols < 0
        begin = self._port(src, "row", after=down, high=cols > 0)
        end = self._port(dst, "column", after=left, high=rows < 0)
        column = dst.col + left
        turn = self.grid.left(column) - self.grid.detail.gap / 2
        y = self._track("row", src.row + down, begin[0], turn)
        x = self._track("column", column, y, end[1])
        label = (begin[0] + _sign(cols) * _LABEL * self.grid.detail.gap, y)
        return (begin, (begin[0], y), (x, y), (x, end[1]), end), label

    def _port(self, pe: PE, way: Way, *, after: bool, high: bool) -> Point:
        """A point on the border of the PE to the channel before or after it that no other has."""
        d = self.grid.detail
        key = (pe.id, way, after, high)
        share = _PORTS[self.ports[key] % len(_PORTS)] + _OPPOSITE * after
        self.ports[key] += 1
        share = share if high else 1 - share
        left, top = self.grid.corner(pe)
        if way == "row":
            return (left + share * d.width, top + after * d.height)
        return (left + after * d.width, top + share * d.height)

    def _track(self, way: Way, channel: int, first: float, last: float) -> float:
        """Where a line along the channel lies; more lines than there are tracks share them."""
        gap = self.grid.detail.gap
        low, high = min(first, last) - gap / 2, max(first, last) + gap / 2
        tracks = [self.taken[way, channel, track] for track in range(len(_TRACKS))]
        free = (
            track
            for track, others in enumerate(tracks)
            if all(end < low or high < begin for begin, end in others)
        )
        track = next(free, sum(map(len, tracks)) % len(_TRACKS))
        tracks[track].append((low, high))
        begin = self.grid.top(channel) if way == "row" else self.grid.left(channel)
        return begin - gap + _TRACKS[track] * gap


def _point(way: Way, along: float, across: float) -> Point:
    return (along, across) if way == "row" else (across, along)


def _bent(path: Path) -> Path:
    """The path with its corners cut, so that it is seen which way a line turns at a crossing."""
    points = [path[0]]
    for before, corner, after in zip(path, path[1:], path[2:], strict=False):
        points += [_towards(corner, before), _towards(corner, after)]
    return (*points, path[-1])


def _towards(corner: Point, other: Point) -> Point:
    """The point _BEND away from the corner, but not beyond the middle."""
    (x0, y0), (x1, y1) = corner, other
    length = abs(x1 - x0) + abs(y1 - y0)
    share = min(_BEND / length, 0.5) if length else 0.0
    return (x0 + share * (x1 - x0), y0 + share * (y1 - y0))


def _sign(number: int) -> int:
    return (number > 0) - (number < 0)
