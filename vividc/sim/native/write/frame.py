"""What the parts of a region's function share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vividc.program.dataflow import Constant, RegionFlow
from vividc.sim.native.plan.counts import CountClass
from vividc.sim.native.write.body import Machine
from vividc.sim.native.write.text import Code


@dataclass
class Frame:
    """A region's function under construction.

    Attributes
    ----------
    sums
        First word of the region's sums.
    begins_early
        A loop may still have been under way when the region began.
    base, entries
        Cycle at which the region starts; regions run, this one included.
    trip
        Iterations unless an exit node ends the loop.
    """

    code: Code
    machine: Machine
    flow: RegionFlow
    classes: Sequence[CountClass]
    switch_cycles: int
    sums: int
    begins_early: bool = False
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
