"""What a mapper returns: time and place of nodes, routes of edges, and what was proved."""

from __future__ import annotations

from collections.abc import Collection
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.host.plot import Picture
from vividc.mapper.problem import ConstantKey

Status = Literal["optimal", "feasible", "infeasible", "timeout"]


@dataclass(frozen=True, slots=True)
class Place:
    """Issues on PE `pe` at cycle `time` of its iteration (0: the iteration's first cycle)."""

    pe: int
    time: int


@dataclass(frozen=True, slots=True, order=True)
class Step:
    """Where a routed word is at cycle `time` (of the producer's iteration).

    kind "link": it was driven onto link `index` in the cycle before and is readable at the link's
    destination PE in cycle `time`. kind "reg": it is in register `index` of PE `pe`, readable in
    cycle `time`; of a rotating file, `index` is the register's name at the start of the producer's
    iteration. kind "out": it is in the output register of PE `pe` (`index` 0) in cycle `time`. For
    links, `pe` is the destination PE.

    A word that enters an output register other than as its operation's result is moved there by the
    FU of that PE, in the cycle before; so is one that enters registers which only the FU writes.
    """

    kind: Literal["link", "reg", "out"]
    pe: int
    index: int
    time: int


@dataclass(frozen=True, slots=True)
class Subject:
    """What was mapped onto what, kept with a result so that it can be explained, drawn and checked.

    `allowed`, `resident`: what was decided before, as in `MapProblem`.
    """

    dfg: DFG
    fabric: Fabric
    allowed: ReadOnly[int, Collection[int]] = field(default_factory=dict)
    resident: ReadOnly[int, Collection[ConstantKey]] = field(default_factory=dict)


@dataclass(frozen=True)
class Mapping:
    """A modulo schedule with routes.

    Attributes
    ----------
    ii
        Initiation interval; for a straight region its length in cycles.
    places
        Place of every placed node (operations and live-outs), by node id.
    routes
        For each index of a routed edge in `dfg.edges`: the steps of the word, one a cycle (several
        where the fabric lets a word pass several links in a cycle, in their order), from
        start[src] + latency(src) to the cycle in which the consumer reads it,
        start[dst] + II * distance. Empty: the consumer, on the same PE, reads the FU's output
        register in the very cycle in which the result appears.
    subject
        The graph and the fabric, where known: `map_dfg` and the JSON reader fill it in.
    """

    ii: int
    places: ReadOnly[int, Place]
    routes: ReadOnly[int, tuple[Step, ...]]
    subject: Subject | None = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        pes = len({place.pe for place in self.places.values()})
        return f"<Mapping at II {self.ii}: {len(self.places)} nodes on {pes} PEs>"

    if TYPE_CHECKING:  # attached by `report.methods`: pictures are made of mappings

        def plot(self, path: str | Path | None = None, subject: Subject | None = None) -> Picture:
            """Draw the array slot by slot and the modulo reservation table."""


@dataclass(frozen=True, slots=True)
class Bound:
    """A proved lower bound on the II, with what binds it in words and as node ids.

    Attributes
    ----------
    edges, distance
        Of a recurrence: its edges as indices of `dfg.edges`, and the sum of their distances. A
        bound that names no edges may mean any between its nodes.
    """

    name: str
    ii: int
    reason: str
    nodes: tuple[int, ...] = ()
    edges: tuple[int, ...] = ()
    distance: int = 0


@dataclass(frozen=True, slots=True)
class Refutation:
    """Why one II is impossible: by a bound, or by a solver that exhausted a complete model."""

    ii: int
    by: str


@dataclass(frozen=True, slots=True)
class Objective:
    """What was minimised at the II, after the II itself.

    Attributes
    ----------
    value, before
        Of the mapping returned, and of the first one found at the II; None: not known.
    bound
        No mapping at this II in which nothing issues after cycle `last_issue` has less; None:
        nothing was proved.
    """

    name: str
    value: int | None
    before: int | None
    bound: int | None
    last_issue: int

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.name}: not tried, the model is too large or time ran out"
        proved = "no bound proved"
        if self.bound is not None:
            least = "the least" if self.bound >= self.value else f"at least {self.bound}"
            proved = f"{least} among schedules that issue nothing after cycle {self.last_issue}"
        first = "" if self.before is None else f" (first found: {self.before})"
        return f"{self.name} {self.value}{first}, {proved}"
