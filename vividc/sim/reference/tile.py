"""A tile under way on the reference engine, and who watches it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from vividc.errors import CycleLimit
from vividc.program import Program
from vividc.sim.engine import Progress
from vividc.sim.reference.predecode import RegionCode, Slot, State, StateMap


class Watch(Protocol):
    """Sees every cycle before it happens."""

    def see(
        self, cycle: int, region: RegionCode, slot: Slot, newest: int, limit: int, state: State
    ) -> None:
        """Look at a cycle; nothing may be changed.

        Parameters
        ----------
        cycle
            Since the launch, stalls included.
        newest, limit
            Iteration of stage 0; iterations from `limit` on are dead.
        state
            The words that PEs can read in this cycle (see `predecode.StateMap`).
        """

    def touch(self, words: Sequence[int]) -> None:
        """Look at what the cycle that was seen last accesses: indices of words of the scratchpad,
        one for each access.
        """


@dataclass
class Tile:
    """What outlives a region: words, memory, the trip register, and the time at which it began."""

    program: Program
    cells: StateMap
    state: State
    memory: list[int]
    cycle_limit: int
    progress: Progress | None
    extents: Mapping[str, tuple[int, int]]
    watch: Watch | None = None
    trip: int = 0
    cycle: int = 0
    entries: int = 0

    def check_limit(self, region: int, now: int) -> None:
        """Stop a run that is in region `region` in cycle `now` if that exceeds the limit.

        Regions entered count too, so regions without a cycle cannot go on for ever.
        """
        if now <= self.cycle_limit and self.entries <= self.cycle_limit:
            return
        report = self.program.regions[region]
        raise CycleLimit(
            f"{self.program.name} is in region {report.name} after {self.cycle_limit} cycles",
            loc=report.loc,
            hint="raise cycle_limit, or look for a loop that never ends",
        )
