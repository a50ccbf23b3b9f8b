"""One search over IIs: what was mapped, what was refuted, what is open."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from vividc.mapper.bounds.refutations import by_bound, by_contexts
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.attempt import Attempt

_TRY_S: Final = 0.001
"""Effort of a try that ends at once: repeated, it takes time, too."""

Strategy = Callable[[MapProblem, int, MapRequest, Deadline, int], Attempt]
"""(problem, II, request, deadline of this try, number of earlier tries of this II)."""


@dataclass
class Campaign:
    """State of one search over IIs; `began`, `improved`: when it began and when the best was found,
    in seconds of effort; `began_s`, `improved_s`: in those of the monotonic clock.
    """

    problem: MapProblem
    request: MapRequest
    strategy: Strategy
    lower: int
    best: Mapping | None = None
    refuted: dict[int, str] = field(default_factory=dict)
    tries: dict[int, int] = field(default_factory=dict)
    began: float = field(init=False)
    improved: float = field(init=False)
    began_s: float = field(default_factory=time.monotonic)
    improved_s: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.began = self.improved = self.request.deadline.meter.spent_s

    def try_ii(self, ii: int, deadline: Deadline) -> Attempt:
        """One more try of `ii`; keeps what it found."""
        count = self.tries.get(ii, 0)
        self.tries[ii] = count + 1
        deadline.charge(_TRY_S)
        attempt = self.strategy(self.problem, ii, self.request, deadline, count)
        self.note(ii, attempt)
        return attempt

    def note(self, ii: int, attempt: Attempt) -> None:
        """Keep what a try of `ii` found; a mapping no better than the best is dropped."""
        if attempt.refuted_by is not None:
            self.refuted[ii] = attempt.refuted_by
            self._raise_lower()
            self.request.tell(f"II {ii}: refuted by {attempt.refuted_by}")
        if attempt.mapping is not None and (self.best is None or ii < self.best.ii):
            self.best = attempt.mapping
            self.improved = self.request.deadline.meter.spent_s
            self.improved_s = time.monotonic()
            self.request.tell(f"II {ii}: mapped")

    def is_ruled_out(self, ii: int) -> bool:
        """Whether a single II that is asked for needs no try; it is then refuted."""
        contexts = self.problem.fabric.controller.contexts
        if ii > contexts:
            self.refuted[ii] = by_contexts(contexts)
        elif ii < self.lower:
            self.refuted[ii] = by_bound(self.lower)
        return ii in self.refuted

    @property
    def unfinished(self) -> bool:
        """Whether a smaller II than the best may exist."""
        return self.best is None or self.lower < self.best.ii

    def open_iis(self) -> list[int]:
        """IIs that are neither refuted nor worse than the best."""
        end = self.lower if self.best is None else self.best.ii
        return [ii for ii in range(self.lower, end) if ii not in self.refuted]

    def _raise_lower(self) -> None:
        while self.lower in self.refuted:
            self.lower += 1
