"""The mapper "sat-kms": the kernel mobility schedule as Booleans, routes and registers after it.

After SAT-MapIt (Tirelli, Ferretti and Pozzi 2023, DATE, "SAT-MapIt: a SAT-based modulo scheduling
mapper for coarse grain reconfigurable architectures"). `cpsat.mobility` solves time and place
without routes; registers follow, as in the publication, and here with them the links that a word
takes between neighbours. A placement whose words do not fit is excluded and the next one asked for,
a few times, before the II grows.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from vividc.mapper.attempt import OPEN, Attempt
from vividc.mapper.cpsat import MobilityModel, Search, fixed, place_and_route
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import MapResult, Place
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.upward import search_upward

_PLACEMENTS: Final = 20
_EXTRA_STAGES: Final = (0, 1)
"""Stages by which the mobility schedule may be longer than the longest path, in turn."""


def sat_kms(problem: MapProblem, request: MapRequest) -> MapResult:
    """Solve the kernel mobility schedule at each II from the MII upward."""
    return search_upward(problem, request, "sat-kms", _try_ii)


def _try_ii(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    for stages in _EXTRA_STAGES:
        part = deadline.within(deadline.remaining_s / (len(_EXTRA_STAGES) - stages))
        model = MobilityModel.of(problem, ii, stages * ii, part)
        if model is None:
            continue
        for number in range(_PLACEMENTS):
            request.tell(f"II {ii}: kernel mobility schedule, placement {number + 1}")
            places = model.solve(Search(part, request.workers, number + tries, light=True))
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
    outcome = place_and_route(fixed(task, ii, times), Search(deadline, 1, light=True))
    return Attempt(mapping=outcome.value)
