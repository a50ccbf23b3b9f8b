"""The mapper "spr": simulated annealing places, negotiation routes, the II grows until both work.

After SPR (Friedman, Carroll, Van Essen, Ylvisaker, Ebeling and Hauck 2009, "SPR: an
architecture-adaptive CGRA mapping tool"): a modulo schedule and its placement by simulated
annealing, then PathFinder (McMurchie and Ebeling 1995) on the time-expanded graph of one II, where
words may share at first and pay for sharing more each round. It starts from scratch at each II, and
knows no repair after routing, which is what `negotiate` adds for the portfolio.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, negotiate
from vividc.mapper.problem import MapProblem
from vividc.mapper.published.upward import attempt_of, upward
from vividc.mapper.request import MapRequest
from vividc.mapper.resources.plain_core import unrotated
from vividc.mapper.result import MapResult
from vividc.mapper.search.state import OPEN, Attempt
from vividc.mapper.search.strategy import run

_SEEDS: Final = 3
"""Placements annealed at an II before it grows."""

_EFFORT: Final = Effort(repairs=0, trials=1)


def spr(problem: MapProblem, request: MapRequest) -> MapResult:
    """Place by annealing and route by negotiation, from the MII upward."""
    return run(upward("spr", _try_ii), problem, request)


def _try_ii(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    core = replace(problem, fabric=unrotated(problem.fabric))
    for seed in range(_SEEDS * tries + 1, _SEEDS * (tries + 1) + 1):
        if deadline.passed:
            break
        request.tell(f"II {ii}: annealing and routing, seed {seed}")
        attempt = attempt_of(problem, negotiate(core, ii, seed, deadline, _EFFORT).mapping)
        if attempt.mapping is not None:
            return attempt
    return OPEN
