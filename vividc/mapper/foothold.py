"""Some mapping of a large graph, by the solver, on fabrics that negotiation does not know."""

from __future__ import annotations

import math
from typing import Final

from vividc.mapper.attempt import is_large, map_decoupled
from vividc.mapper.campaign import Campaign
from vividc.mapper.problem import MapProblem

_LARGE: Final = 48
_FACTORS: Final = (1.7, 2.5, 4.0)
_SHARE: Final = 0.35
_FIRST_SEED: Final = 1
"""The schedules of other tries of the same II begin with seeds that are multiples of 1000."""


def needs_foothold(problem: MapProblem) -> bool:
    """Whether the way upward from the bound may take all the time there is."""
    return len(problem.dfg.placed) >= _LARGE and not is_large(problem)


def gain_foothold(campaign: Campaign, limit: int) -> None:
    """A mapping well above the bound, or farther above it, each with a share of the time."""
    deadline = campaign.request.deadline
    for factor in _FACTORS:
        ii = min(math.ceil(factor * campaign.lower), limit)
        share = deadline.within(_SHARE * deadline.remaining_s)
        campaign.note(ii, map_decoupled(campaign.problem, ii, campaign.request, share, _FIRST_SEED))
        if campaign.best is not None or deadline.passed:
            return
