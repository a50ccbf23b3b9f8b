"""What `map_dfg` returns: a mapping, and what was proved of its II."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace

from vividc.errors import VividcError
from vividc.mapper.mapping import Bound, Mapping, Objective, Refutation, Status, Subject


@dataclass(frozen=True)
class MapResult:
    """The outcome of `map_dfg`.

    Attributes
    ----------
    status
        "optimal": every II below `ii` was refuted. "feasible": mapped, but the IIs from
        `lower_bound` to `ii` - 1 are open. "infeasible": no II can work (or the requested one
        cannot). "timeout": nothing found in time.
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

    @property
    def claim(self) -> str:
        """The status, with the words "within the added constraints" where that limits it."""
        limited = self.constrained and self.status in ("optimal", "infeasible")
        return f"{self.status} within the added constraints" if limited else self.status

    def explain(self) -> str:
        """What was proved and what binds, in a few lines for a person: the recurrence with its
        source lines, the resource with its users, or what is fullest where routing binds.
        """
        from vividc.mapper.report.explain import explain  # it needs this module  # noqa: PLC0415

        return explain(self)

    def to_json(self, subject: Subject | None = None) -> dict[str, object]:
        """A JSON-ready object with the whole certificate, graph and fabric (`report.document`).

        Raises
        ------
        VividcError
            The result does not know its graph and fabric, and none are given.
        """
        from vividc.mapper.report.document import mapping_to_json  # as above  # noqa: PLC0415

        about = subject or self.subject
        if about is None:
            raise VividcError(
                "the result does not know its graph and fabric",
                loc="to_json",
                hint="pass subject=Subject(dfg, fabric)",
            )
        return mapping_to_json(replace(self, subject=about), about.dfg, about.fabric)

    @staticmethod
    def from_json(data: object) -> MapResult:
        """The result that `to_json` wrote, with the graph and the fabric in it as `subject`.

        Raises
        ------
        VividcError
            `data` is no such object, or of another version.
        """
        from vividc.mapper.report.document import read_result  # as above  # noqa: PLC0415

        return read_result(data)


class MapInterrupted(KeyboardInterrupt):
    """An interrupt of a search that has a mapping: `result` is what it found and proved so far."""

    def __init__(self, result: MapResult) -> None:
        self.result = result
        super().__init__()
