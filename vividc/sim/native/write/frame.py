"""What the parts of a region's function share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vividc.program import RegionRow, loop_behind
from vividc.program.dataflow import Constant, RegionFlow
from vividc.program.reloads import Reloads
from vividc.sim.native.plan.counts import CountClass
from vividc.sim.native.write.body import Machine
from vividc.sim.native.write.text import Code


@dataclass(frozen=True)
class Overlap:
    """What may be under way in cycles of a region: the region before it, when it begins
    (`begins_early`); and in its last `fill` cycles the loop behind it, which begins then if it has
    `least` iterations or more.
    """

    begins_early: bool
    fill: int
    loop: int | None = None
    least: int = 0

    @staticmethod
    def of(table: Sequence[RegionRow], index: int) -> Overlap:
        """By a region table."""
        early = any(row.drain and row.next == index for row in table)
        early |= any(row.fill and loop_behind(table, n) == index for n, row in enumerate(table))
        fill, loop = table[index].fill, loop_behind(table, index)
        if not fill or loop is None:
            return Overlap(early, 0)
        return Overlap(early, fill, loop, table[loop].least_trips(fill))


@dataclass
class Frame:
    """A region's function under construction.

    Attributes
    ----------
    sums
        First word of the region's sums.
    base, entries
        Cycle at which the region starts, also if the one before it is still under way; regions run,
        this one included.
    trip
        Iterations unless an exit node ends the loop.
    """

    code: Code
    machine: Machine
    flow: RegionFlow
    classes: Sequence[CountClass]
    switch_cycles: int
    sums: int
    overlap: Overlap
    reloads: Reloads | None = None
    base: str = ""
    entries: str = ""
    trip: str = "1"

    @property
    def written(self) -> tuple[Constant, ...]:
        """Constant-store entries that live-outs write."""
        return tuple(dict.fromkeys(capture.target for capture in self.flow.captures))

    @property
    def bits(self) -> tuple[int, ...]:
        """Valid bits that live-outs may set."""
        known = self.machine.layout.bits
        return tuple(known[constant] for constant in self.written if constant in known)

    def get(self, place: int) -> str:
        """A word of the context."""
        return self.code.load("i64", "%context", place)

    def set(self, place: int, value: str) -> None:
        """Set a word of the context."""
        self.code.store("i64", value, "%context", place)
