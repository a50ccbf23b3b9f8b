"""Programs longer than the configuration memory: what entering a region brings there, and when.

Context n has place n modulo the memory's contexts (docs/machine.md, "Long programs").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.host.once import once_within
from vividc.program.program import Program

_BROUGHT: Final = "the contexts of one of them may have to be brought first"
"""Why no region begins while another ends."""
_MEMORIES: Final = 16
"""That the contexts of a program would fill, at most."""


def most_contexts(fabric: Fabric) -> int:
    """Return how many contexts a program may have."""
    return _MEMORIES * fabric.controller.contexts


@dataclass(frozen=True, slots=True)
class Reload:
    """What brings a region's contexts.

    Attributes
    ----------
    cycles
        In which they are written: an entry of a PE and context each.
    evicted
        Regions of whose contexts some are overwritten: a bit each.
    """

    cycles: int
    evicted: int


@dataclass(frozen=True, slots=True)
class Reloads:
    """What the tile controller knows of a long program.

    Attributes
    ----------
    held
        Regions whose contexts the memory holds at launch: a bit each.
    rows
        By region.
    """

    held: int
    rows: tuple[Reload, ...]

    def stays(self, region: int) -> bool:
        """Whether a region's contexts are there all the time."""
        return bool(self.held >> region & 1) and not self.rows[region].evicted

    def entered(self, region: int, held: int) -> tuple[int, int]:
        """Cycles in which a region's contexts are brought, none if they are held, and which regions
        are held then.
        """
        if held >> region & 1:
            return 0, held
        row = self.rows[region]
        return row.cycles, held & ~row.evicted | 1 << region


@once_within
def reloads_of(program: Program) -> Reloads | None:
    """Return the reloads of a program; None: the configuration memory holds all of it."""
    places = program.fabric.controller.contexts
    if len(program.words) <= places:
        return None
    users = [0] * places
    for index, row in enumerate(program.table):
        for context in range(row.context, row.context + row.ii):
            users[context % places] |= 1 << index
    pes, rows, held = len(program.fabric.pes), [], 0
    for index, row in enumerate(program.table):
        evicted = 0
        for context in range(row.context, row.context + row.ii):
            evicted |= users[context % places]
        rows.append(Reload(pes * row.ii, evicted & ~(1 << index)))
        held |= (row.context + row.ii <= places) << index
    return Reloads(held, tuple(rows))


def overlap_fault(program: Program, *regions: int) -> str | None:
    """Why regions cannot be under way at the same time, by where their contexts lie."""
    reloads = reloads_of(program)
    return None if reloads is None or all(map(reloads.stays, regions)) else _BROUGHT
