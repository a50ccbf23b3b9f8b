"""What a mapper's search consists of, as rows of data, and the walk over IIs that reads them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.deadline import Deadline
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.result import MapInterrupted, MapResult
from vividc.mapper.search.state import OPEN, Attempt, IISearch, TryII, is_large


@dataclass(frozen=True, slots=True)
class Step:
    """A way to refute or to map one II.

    Attributes
    ----------
    share
        Of the time for the II that is left when the step begins.
    extended
        Also where the caller adds constraints (`MapRequest.extend`).
    """

    run: TryII
    share: float = 1.0
    extended: bool = True


@dataclass(frozen=True, slots=True)
class Phase:
    """A part of the walk over IIs.

    Attributes
    ----------
    graphs
        Which graphs have it: "large" ones (`is_large`), "small" ones or "all".
    extended
        Also where the caller adds constraints, which negotiation does not know.
    unless_mapped
        Left out where there is an incumbent already.
    """

    run: Callable[[IISearch], None]
    graphs: Literal["all", "small", "large"] = "all"
    extended: bool = True
    unless_mapped: bool = False

    def applies(self, search: IISearch) -> bool:
        """Whether the search has this phase now."""
        size = "large" if is_large(search.problem) else "small"
        if self.graphs not in ("all", size):
            return False
        if search.request.extend is not None and not self.extended:
            return False
        return search.incumbent is None or not self.unless_mapped


@dataclass(frozen=True, slots=True)
class Strategy:
    """A mapper as data.

    Attributes
    ----------
    steps
        How one II is tried: in this order, until it is mapped or refuted.
    phases
        The walk over IIs, in this order.
    only
        The phases where the caller asks for one II.
    """

    name: str
    steps: tuple[Step, ...]
    phases: tuple[Phase, ...]
    only: tuple[Phase, ...]

    def try_ii(
        self, problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
    ) -> Attempt:
        """Try one II by the steps."""
        for step in self.steps:
            if request.extend is not None and not step.extended:
                continue
            part = deadline
            if step.share < 1:
                part = deadline.within(deadline.remaining_s * step.share)
            attempt = step.run(problem, ii, request, part, tries)
            if attempt.decided:
                return attempt
        return OPEN


def run(
    strategy: Strategy, problem: MapProblem, request: MapRequest, *, on_window: bool = False
) -> MapResult:
    """Search for the least II; `on_window`: the fabric is a rectangle of the array.

    Raises
    ------
    MapInterrupted
        A KeyboardInterrupt came when there was an incumbent.
    """
    began_s = time.monotonic()
    bounds = all_bounds(problem)
    in_window = None if on_window else partial(run, strategy, on_window=True)
    search = IISearch(
        problem, request, strategy.try_ii, mii(bounds), request.known, in_window=in_window
    )
    try:
        infeasible = _walk(strategy, search)
    except KeyboardInterrupt as stop:
        if search.incumbent is None:
            raise
        result = search.result(bounds, strategy.name, began_s, infeasible=False)
        raise MapInterrupted(result) from stop
    return search.result(bounds, strategy.name, began_s, infeasible=infeasible)


def _walk(strategy: Strategy, search: IISearch) -> bool:
    """Go through the phases; whether no II maps, or not the one that is asked for."""
    nothing, ii = no_ii(search.problem), search.request.ii
    if search.lower >= nothing:
        return True
    if ii is not None and search.rules_out(ii):
        return True
    for phase in strategy.phases if ii is None else strategy.only:
        if phase.applies(search):
            phase.run(search)
    if ii is not None:
        return ii in search.refuted
    return search.incumbent is None and search.lower >= nothing
