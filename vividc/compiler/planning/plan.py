"""A plan: the stages of a kernel from as written to most transformed, and what was decided."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.compiler.planning.candidates import Kind, State
from vividc.compiler.planning.estimate import Estimate
from vividc.errors import SourceLoc


@dataclass(frozen=True, slots=True)
class Decision:
    """One transformation that was tried.

    Attributes
    ----------
    header, origin
        The loop, and the loop of the source that it comes from.
    before, after
        Estimated cycles of one run of the kernel; `after` is None if it was refused.
    reason
        Why it was refused or does not pay; else empty.
    """

    kind: Kind
    header: str
    origin: str
    factor: int
    loc: SourceLoc | None
    before: float
    after: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Stage:
    """A function to map, its estimate, and the decision that made it of the stage `base`.

    `reserve`: the next stage is better by estimate; this one takes fewer contexts, and is for when
    that cannot be mapped.
    """

    state: State
    estimate: Estimate
    decision: Decision | None = None
    base: Stage | None = None
    reserve: bool = False

    def lineage(self) -> Iterator[Stage]:
        """The stage, the one that it was made of, and so on to the first."""
        yield self
        if self.base is not None:
            yield from self.base.lineage()


@dataclass(frozen=True)
class Plan:
    """Stages from the kernel as it was to the most transformed one, and what was decided.

    `asked` is the last stage that the user asks for. If nests are restructured, stages without that
    are among those before it, or behind it where they are the better ones.
    """

    stages: tuple[Stage, ...]
    decisions: tuple[Decision, ...] = ()
    asked: int = 0
