"""A tile under way on the reference engine, and who watches it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, Protocol

from vividc.errors import CycleLimit, SimulationError
from vividc.machine.words import WORD_BYTES
from vividc.program import Program
from vividc.sim.engine import Progress
from vividc.sim.reference.predecode import Op, RegionCode, Slot, State, StateMap

SIGN_BIT: Final = 0x80000000
Role = Literal["issue", "live_out"]


class Moment(NamedTuple):
    """A region's context, and the cycle since the launch."""

    region: int
    slot: int
    now: int


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

    def fault(
        self, at: Moment, pe: int, role: Role | None, what: str, hint: str | None
    ) -> SimulationError:
        """The error of something that a PE did; `role`: which of its operations, if one did."""
        program, report = self.program, self.program.regions[at.region]
        row = program.debug_row(at.region, at.slot, pe, role) if role is not None else None
        op = "" if row is None else f" ({row.op} {row.name}".rstrip() + ")"
        return SimulationError(
            f"{what}: PE {pe}{op}, region {report.name}, cycle {at.now}",
            loc=report.loc if row is None else row.loc,
            hint=hint,
        )

    def bad_address(self, op: Op, address: int) -> str:
        """What is wrong with the address of an access."""
        what = "a misaligned" if address % op.issue.width else "an out-of-bounds"
        first, end = self.extents.get(op.array, (0, WORD_BYTES * len(self.memory)))
        place = f"the array {op.array}" if op.array in self.extents else "the scratchpad"
        byte = address - first if address - first < SIGN_BIT else address - first - (1 << 32)
        return f"{what} access at byte {byte} of {place}, which has {end - first}"
