"""The mapper "sat-kms": the kernel mobility schedule as Booleans, routes and registers after it.

After SAT-MapIt (Tirelli, Ferretti and Pozzi 2023, DATE, "SAT-MapIt: a SAT-based modulo scheduling
mapper for coarse grain reconfigurable architectures"). `cpsat.mobility` solves time and place
without routes; registers follow, as in the publication, and here with them the links that a word
takes between neighbours. A placement whose words do not fit is excluded and the next one asked for,
a few times, before the II grows.
"""

from __future__ import annotations

from vividc.mapper.problem import MapProblem
from vividc.mapper.published.upward import upward
from vividc.mapper.request import MapRequest
from vividc.mapper.result import MapResult
from vividc.mapper.search.kms import map_by_mobility
from vividc.mapper.search.strategy import run


def sat_kms(problem: MapProblem, request: MapRequest) -> MapResult:
    """Solve the kernel mobility schedule at each II from the MII upward."""
    return run(upward("sat-kms", map_by_mobility), problem, request)
