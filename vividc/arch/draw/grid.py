"""Where the PEs of a picture lie, and how large they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

from vividc.arch.fabric import PE, Fabric, Link

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Detail:
    """Sizes in points. `chips`: held words are named one by one; `names`: operations are named."""

    width: float
    height: float
    gap: float
    font: float
    chips: int
    names: bool
    wire: float


FULL: Final = Detail(82, 60, 34, 10.5, 6, True, 1.3)
_MEDIUM: Final = Detail(50, 38, 24, 9, 2, True, 1.1)
_SMALL: Final = Detail(25, 20, 15, 8, 0, False, 0.9)
_FULL_UP_TO: Final = 36
_MEDIUM_UP_TO: Final = 100
HEADER: Final = 18.0


@dataclass(frozen=True)
class Grid:
    """The PEs of one panel; its origin is the top left corner of the panel."""

    fabric: Fabric

    @cached_property
    def detail(self) -> Detail:
        """How much of a PE can be shown in an array of this size."""
        pes = len(self.fabric.pes)
        if pes <= _FULL_UP_TO:
            return FULL
        return _MEDIUM if pes <= _MEDIUM_UP_TO else _SMALL

    @property
    def width(self) -> float:
        """Width of a panel, margins included."""
        d = self.detail
        return self.fabric.cols * (d.width + d.gap) - d.gap + 2 * self.margin

    @property
    def height(self) -> float:
        """Height of a panel, its header and margins included."""
        d = self.detail
        return HEADER + self.fabric.rows * (d.height + d.gap) - d.gap + 2 * self.margin

    @cached_property
    def margin(self) -> float:
        """Room around the PEs: for long links where there are any."""
        gap = self.detail.gap
        long = any(self.span(link) > 1 for link in self.fabric.links)
        return gap + 6 if long else max(12.0, 0.4 * gap)

    def span(self, link: Link) -> int:
        """Rows or columns that the link crosses, whichever are more; 1: between neighbours."""
        src, dst = self.fabric.pes[link.src], self.fabric.pes[link.dst]
        return max(abs(dst.row - src.row), abs(dst.col - src.col))

    def corner(self, pe: PE) -> Point:
        """The top left corner of the PE."""
        return self.left(pe.col), self.top(pe.row)

    def left(self, col: int) -> float:
        """The left border of the PEs in a column."""
        return self.margin + col * (self.detail.width + self.detail.gap)

    def top(self, row: int) -> float:
        """The upper border of the PEs in a row."""
        return HEADER + self.margin + row * (self.detail.height + self.detail.gap)
