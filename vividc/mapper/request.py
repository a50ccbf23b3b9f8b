"""What a caller asks of a mapper besides the problem itself, and the type of a mapper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.result import MapResult

if TYPE_CHECKING:
    from vividc.mapper.engines.cpsat.handle import Extension

Progress = Callable[[str], None]

EffortLevel = Literal["fast", "normal", "thorough", "prove"]
"""Where a search stops before its deadline: "fast" at the first good mapping, "normal" where more
work rarely pays, "thorough" where none is expected to, "prove" once every smaller II is refuted
(`mapper/search/state.py`).
"""
EFFORT_LEVELS: Final[tuple[EffortLevel, ...]] = get_args(EffortLevel)


@dataclass(frozen=True, slots=True)
class MapRequest:
    """Limits of one run.

    Attributes
    ----------
    ii
        The only II to try; None: the least.
    deadline
        When to stop, found or not.
    workers
        Threads that may be used; more than two find no work. Their number changes no result.
    progress
        Called with one line at each step; None: silent.
    effort
        Where to stop before the deadline.
    part
        Of its effort's patience, that the search has: a kernel's loops share it.
    extend
        Adds a caller's constraints to every model whose solution becomes a mapping.
    known
        A mapping that the caller already has: only smaller IIs are of use, and it is the result if
        none is found.
    """

    ii: int | None
    deadline: Deadline
    workers: int = 2
    progress: Progress | None = None
    effort: EffortLevel = "prove"
    extend: Extension | None = None
    known: Mapping | None = None
    part: float = 1.0

    def tell(self, line: str) -> None:
        """Report progress."""
        if self.progress is not None:
            self.progress(line)


Mapper = Callable[[MapProblem, MapRequest], MapResult]
"""A mapper. Entry points of the group "vividc.mappers" load to one; its mappings are verified by
`map_dfg`.
"""
