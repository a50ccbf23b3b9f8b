"""What `map_dfg` returns: a mapping, and what was proved of its II."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vividc.errors import InternalError
from vividc.mapper.mapping import Bound, Mapping, Objective, Refutation, Status, Subject


@dataclass(frozen=True)
class MapResult:
    """The outcome of `map_dfg`.

    Attributes
    ----------
    status
        "optimal": every II below `ii` was refuted. "feasible": mapped, but the IIs from
        `lower_bound` to `ii` - 1 are open. "infeasible": no II can work (or the requested one
        cannot). "timeout": no mapping was found in time.
    bounds
        All bounds, sharpest first.
    refuted
        The refutations behind `lower_bound`.
    wall_s
        Seconds spent.
    constrained
        The caller added constraints: "optimal" and "infeasible" hold within them. Bounds are
        those of the problem without them, and so hold as well.
    objective
        What was minimised at the II, if anything.
    hurried
        The clock stopped the search before its effort was spent: another run may find another
        mapping.
    """

    status: Status
    ii: int | None
    lower_bound: int
    bounds: tuple[Bound, ...]
    mapping: Mapping | None
    mapper: str
    wall_s: float
    refuted: tuple[Refutation, ...] = ()
    stats: ReadOnly[str, float] = field(default_factory=dict)
    subject: Subject | None = field(default=None, compare=False, repr=False)
    constrained: bool = False
    objective: Objective | None = None
    hurried: bool = False

    def __repr__(self) -> str:
        found = "no mapping" if self.ii is None else f"II {self.ii}"
        return f"<MapResult: {found}, {self.claim}; lower bound {self.lower_bound}; {self.mapper}>"

    @property
    def claim(self) -> str:
        """The status, qualified by "within the added constraints" where it only holds there."""
        limited = self.constrained and self.status in ("optimal", "infeasible")
        return f"{self.status} within the added constraints" if limited else self.status

    if TYPE_CHECKING:  # attached by `report.methods`: reports are made of results

        def explain(self) -> str:
            """What was proved and what binds, in a few lines for a person."""

        def to_json(self, subject: Subject | None = None) -> dict[str, object]:
            """A JSON-ready object with the whole certificate, graph and fabric."""

        @staticmethod
        def from_json(data: object) -> MapResult:
            """The result that `to_json` wrote."""


def mapping_of(result: MapResult) -> Mapping:
    """The mapping that a result must have.

    Raises
    ------
    InternalError
        It has none.
    """
    if result.mapping is None:
        raise InternalError("a region without a mapping was passed on")
    return result.mapping


class MapInterrupted(KeyboardInterrupt):
    """A search was interrupted after its first mapping: `result` is what it found and proved."""

    def __init__(self, result: MapResult) -> None:
        self.result = result
        super().__init__()
