"""One II by the kernel mobility schedule: Booleans for time and place, then routes and
registers.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.mapper.deadline import Deadline
from vividc.mapper.engines import cpsat
from vividc.mapper.mapping import Place
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.state import OPEN, Attempt
from vividc.mapper.search.tuning import MOBILITY_EXTRA_STAGES, MOBILITY_PLACEMENTS


def map_by_mobility(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    """Placements in turn until one has routes; nothing is refuted, since moves and lives beyond the
    II are left out.
    """
    for stages in MOBILITY_EXTRA_STAGES:
        part = deadline.within(deadline.remaining_s / (len(MOBILITY_EXTRA_STAGES) - stages))
        model = cpsat.MobilityModel.of(problem, ii, stages * ii, part)
        if model is None:
            continue
        for number in range(MOBILITY_PLACEMENTS):
            request.tell(f"II {ii}: kernel mobility schedule, placement {number + 1}")
            places = model.solve(cpsat.Search(part, request.workers, number + tries, light=True))
            if places is None:
                break
            attempt = _route(problem, ii, places, part)
            if attempt.mapping is not None:
                return attempt
            model.exclude(places)
    return OPEN


def _route(problem: MapProblem, ii: int, places: dict[int, Place], deadline: Deadline) -> Attempt:
    """Links and registers for fixed times and places."""
    here = {node: frozenset({place.pe}) for node, place in places.items()}
    times = {node: place.time for node, place in places.items()}
    task = replace(problem, allowed=here)
    outcome = cpsat.place_and_route(
        cpsat.fixed(task, ii, times), cpsat.Search(deadline, 1, light=True)
    )
    return Attempt(mapping=outcome.value)
