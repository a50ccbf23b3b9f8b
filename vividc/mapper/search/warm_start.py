"""A first mapping of a small graph, found quickly: at the bound, or where constraints take long.

That gives only an incumbent: the IIs below it are tried and refuted as ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from vividc.mapper.engines.negotiate import Effort
from vividc.mapper.search.attempt import needs_warm_start
from vividc.mapper.search.climb import first_turn
from vividc.mapper.search.kms import map_by_mobility
from vividc.mapper.search.negotiation import climb, descend, negotiate
from vividc.mapper.search.state import IISearch, ii_limit
from vividc.mapper.search.tuning import (
    BOUND_SHARE,
    MOBILITY_SHARE,
    MOBILITY_STEPS,
    NEGOTIATED_GRAPH,
    QUICK,
    SHORT,
    WARM_START_LEAST_S,
    WARM_START_SHARE,
)


def negotiate_at_bound(search: IISearch) -> None:
    """Quick negotiations at the bound: where one maps the graph, it takes a twentieth of what
    constraints do. Iterations are to be as short as dependences allow, or little longer, those of
    graphs that are not quite small of any length at last.
    """
    if search.lower > ii_limit(search.problem):
        return
    any_length = len(search.problem.dfg.placed) >= NEGOTIATED_GRAPH
    for longer in (*SHORT, None) if any_length else SHORT:
        if negotiate(search, search.lower, 1, QUICK, longer=longer).mapping is not None:
            return


def solve_at_bound(search: IISearch) -> None:
    """A turn for constraints at the bound. Where words take links they often map there at once;
    where they do not, the way upward from there is long.
    """
    if search.unfinished and not needs_warm_start(search.problem):
        deadline = search.request.deadline
        half = deadline.within(deadline.remaining_s * BOUND_SHARE)
        search.try_ii(search.lower, half.within(first_turn(search.request).remaining_s))


def warm_start(search: IISearch) -> None:
    """Where nothing is mapped: an incumbent by negotiation; if that finds none, by the kernel
    mobility schedule.
    """
    limit = ii_limit(search.problem)
    if search.incumbent is not None or search.lower > limit:
        return
    with _short_deadline(search):
        if negotiate(search, search.lower, 1, QUICK).mapping is not None:
            return
        climb(search, limit)
        descend(search, Effort())
    if search.incumbent is None:
        _start_by_mobility(search, limit)


@contextmanager
def _short_deadline(search: IISearch) -> Iterator[None]:
    request = search.request
    share_s = max(WARM_START_LEAST_S, WARM_START_SHARE * request.deadline.remaining_s)
    search.request = replace(request, deadline=request.deadline.within(share_s))
    try:
        yield
    finally:
        search.request = request


def _start_by_mobility(search: IISearch, limit: int) -> None:
    """The first of some IIs from the bound on, each with a share of the time."""
    deadline = search.request.deadline
    for ii in dict.fromkeys(min(math.ceil(step * search.lower), limit) for step in MOBILITY_STEPS):
        share = deadline.within(MOBILITY_SHARE * deadline.remaining_s)
        search.record(ii, map_by_mobility(search.problem, ii, search.request, share, 0))
        if search.incumbent is not None or deadline.passed:
            return
