"""One search over IIs: the incumbent (the best mapping so far), what was refuted, what is open."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from vividc.errors import InternalError
from vividc.mapper.bounds.refutations import by_bound, by_contexts
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Bound, Mapping, Refutation, Status
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import Mapper, MapRequest
from vividc.mapper.resources.distances import hop_distances
from vividc.mapper.result import MapResult
from vividc.mapper.search.tuning import LARGE_GRAPH, NEAR, PATIENCES, TRY_S


@dataclass(frozen=True, slots=True)
class Attempt:
    """What became of one II: a mapping, a refutation (`refuted_by`), or neither, and then whether
    it `is_far` from a mapping: more effort at this II is not expected to find one.
    """

    mapping: Mapping | None = None
    refuted_by: str | None = None
    is_far: bool = False

    @property
    def decided(self) -> bool:
        """Mapped or refuted."""
        return self.mapping is not None or self.refuted_by is not None


OPEN = Attempt()

TryII = Callable[[MapProblem, int, MapRequest, Deadline, int], Attempt]
"""(problem, II, request, deadline of this try, number of earlier tries of this II)."""


@dataclass
class IISearch:
    """State of one search over IIs.

    Attributes
    ----------
    attempt
        How one II is tried.
    lower
        Every smaller II is refuted.
    incumbent
        The mapping with the least II so far.
    in_window
        The same strategy for a rectangle of the array; None: this search is on one.
    far
        The greatest II that was far from a mapping: smaller ones are, too.
    over
        Nothing that is left to try is worth what is left of the patience.
    began, improved
        When the search began and when the incumbent was found, in seconds of effort; `began_s`,
        `improved_s`: by the monotonic clock.
    """

    problem: MapProblem
    request: MapRequest
    attempt: TryII
    lower: int
    incumbent: Mapping | None = None
    in_window: Mapper | None = None
    far: int = 0
    over: bool = False
    refuted: dict[int, str] = field(default_factory=dict)
    tries: dict[int, int] = field(default_factory=dict)
    began: float = field(init=False)
    improved: float = field(init=False)
    began_s: float = field(default_factory=time.monotonic)
    improved_s: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.began = self.improved = self.request.deadline.meter.spent_s

    def try_ii(self, ii: int, deadline: Deadline) -> Attempt:
        """Try `ii` once more and record what comes of it."""
        count = self.tries.get(ii, 0)
        self.tries[ii] = count + 1
        deadline.charge(TRY_S)
        attempt = self.attempt(self.problem, ii, self.request, deadline, count)
        self.record(ii, attempt)
        return attempt

    def record(self, ii: int, attempt: Attempt) -> None:
        """Keep what a try of `ii` came to; a mapping no better than the incumbent is dropped."""
        if attempt.refuted_by is not None:
            self.refuted[ii] = attempt.refuted_by
            while self.lower in self.refuted:
                self.lower += 1
            self.request.tell(f"II {ii}: refuted by {attempt.refuted_by}")
        if attempt.is_far:
            self.far = max(self.far, ii)
        if attempt.mapping is not None and (self.incumbent is None or ii < self.incumbent.ii):
            self.incumbent = attempt.mapping
            self.improved = self.request.deadline.meter.spent_s
            self.improved_s = time.monotonic()
            self.request.tell(f"II {ii}: mapped")

    @property
    def only_ii(self) -> int:
        """The only II to try, in a search that has one."""
        if self.request.ii is None:
            raise InternalError("a search for one II was asked for none")
        return self.request.ii

    def rules_out(self, ii: int) -> bool:
        """Whether the bound or the configuration memory refutes `ii`, which is then recorded."""
        contexts = self.problem.fabric.controller.contexts
        if ii > contexts:
            self.refuted[ii] = by_contexts(contexts)
        elif ii < self.lower:
            self.refuted[ii] = by_bound(self.lower)
        return ii in self.refuted

    @property
    def deadline(self) -> Deadline:
        """The request's, which its effort brings forward once something is mapped: to where work
        has brought nothing for as long as its patience lasts.
        """
        deadline = self.request.deadline
        if self.incumbent is None or self.request.effort == "prove":
            return deadline
        if self.over:
            return replace(deadline, at=min(deadline.at, deadline.meter.spent_s))
        patience = PATIENCES[self.request.effort]
        least_s = patience.least_s * (self.request.part if patience.shared else 1.0)
        patience_s = max(least_s, patience.factor * (self.improved - self.began))
        least = max(self.lower, self.far + 1)
        if self.incumbent.ii - least <= max(NEAR, patience.good * self.lower):
            patience_s *= patience.near
        elif is_large(self.problem):
            patience_s *= patience.large
        return replace(deadline, at=min(deadline.at, self.improved + patience_s))

    @property
    def unfinished(self) -> bool:
        """Whether a smaller II than the incumbent's may exist."""
        return self.incumbent is None or self.lower < self.incumbent.ii

    def open_iis(self) -> list[int]:
        """IIs below the incumbent's that are not refuted."""
        end = self.lower if self.incumbent is None else self.incumbent.ii
        return [ii for ii in range(self.lower, end) if ii not in self.refuted]

    def result(
        self, bounds: tuple[Bound, ...], name: str, began_s: float, *, infeasible: bool
    ) -> MapResult:
        """What is known now, as the result of the mapper `name`."""
        best = self.incumbent
        refuted = [Refutation(ii, by) for ii, by in sorted(self.refuted.items())]
        return MapResult(
            status="infeasible" if infeasible else self._status(),
            ii=None if best is None else best.ii,
            lower_bound=self.lower,
            bounds=bounds,
            mapping=best,
            mapper=name,
            wall_s=time.monotonic() - began_s,
            refuted=tuple(item for item in refuted if best is None or item.ii < best.ii),
            stats={
                "tries": float(sum(self.tries.values())),
                "found_s": self.improved_s - self.began_s,
            },
            constrained=self.request.extend is not None,
        )

    def _status(self) -> Status:
        if self.incumbent is None:
            return "timeout"
        return "feasible" if self.unfinished else "optimal"


def is_large(problem: MapProblem) -> bool:
    """Whether placing and routing by constraints takes longer than by negotiation."""
    return len(problem.dfg.placed) >= LARGE_GRAPH


def ii_limit(problem: MapProblem) -> int:
    """An II beyond which trying makes no sense: all operations one after another, each as far as
    the array is wide.
    """
    hops = hop_distances(problem.fabric)
    reachable = [d for row in hops for d in row if d < len(hops)]
    step = max(reachable, default=0) + problem.fabric.controller.control_latency + 1
    length = sum(problem.fabric.latency(node) + step for node in problem.dfg.placed)
    return min(problem.fabric.controller.contexts, max(length, 1))
