"""Some mapping soon, on fabrics where placing and routing by constraints takes long to find any.

What a foothold finds is only the start: the IIs below it are tried and refuted as ever.
"""

from __future__ import annotations

import math
from typing import Final

from vividc.mapper.attempt import is_large, map_decoupled
from vividc.mapper.campaign import Campaign
from vividc.mapper.kms import map_by_mobility
from vividc.mapper.large import gain_by_negotiation
from vividc.mapper.problem import MapProblem

_LARGE: Final = 48
_FACTORS: Final = (1.7, 2.5, 4.0)
_SHARE: Final = 0.35
_FIRST_SEED: Final = 1
"""The schedules of other tries of the same II begin with seeds that are multiples of 1000."""
_STEPS: Final = (1.0, 1.3, 1.7, 2.2, 3.0)
_STEP_SHARE: Final = 0.2


def needs_foothold(problem: MapProblem) -> bool:
    """Whether the way upward from the bound may take all the time there is."""
    if is_large(problem):
        return False
    return len(problem.dfg.placed) >= _LARGE or not problem.fabric.is_plain


def gain_foothold(campaign: Campaign, limit: int) -> None:
    """A mapping by negotiation; where that finds none by the kernel mobility schedule, and
    schedules first, well above the bound.
    """
    campaign.request = gain_by_negotiation(campaign, limit)
    if campaign.best is not None:
        return
    _by_mobility(campaign, limit)
    if campaign.best is None and len(campaign.problem.dfg.placed) >= _LARGE:
        _by_schedules(campaign, limit)


def _by_mobility(campaign: Campaign, limit: int) -> None:
    """The first of some IIs from the bound on, each with a share of the time."""
    deadline = campaign.request.deadline
    iis = dict.fromkeys(min(math.ceil(step * campaign.lower), limit) for step in _STEPS)
    for ii in iis:
        share = deadline.within(_STEP_SHARE * deadline.remaining_s)
        campaign.note(ii, map_by_mobility(campaign.problem, ii, campaign.request, share, 0))
        if campaign.best is not None or deadline.passed:
            return


def _by_schedules(campaign: Campaign, limit: int) -> None:
    """A mapping well above the bound, or farther above it, each with a share of the time."""
    deadline = campaign.request.deadline
    for factor in _FACTORS:
        ii = min(math.ceil(factor * campaign.lower), limit)
        share = deadline.within(_SHARE * deadline.remaining_s)
        campaign.note(ii, map_decoupled(campaign.problem, ii, campaign.request, share, _FIRST_SEED))
        if campaign.best is not None or deadline.passed:
            return
