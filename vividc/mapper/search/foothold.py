"""Some mapping soon, where placing and routing by constraints takes long to find any.

What a foothold finds is only the start: the IIs below it are tried and refuted as ever.
"""

from __future__ import annotations

import math
from typing import Final

from vividc.mapper.problem import MapProblem
from vividc.mapper.search.attempt import is_large
from vividc.mapper.search.campaign import Campaign
from vividc.mapper.search.kms import map_by_mobility
from vividc.mapper.search.large import gain_by_negotiation

_STEPS: Final = (1.0, 1.3, 1.7, 2.2, 3.0)
_STEP_SHARE: Final = 0.2
_LARGE_ARRAY: Final = 16


def needs_foothold(problem: MapProblem) -> bool:
    """Whether constraints may take all the time there is on the way upward from the bound: on large
    arrays, and where words do not only take links.
    """
    fabric = problem.fabric
    return not is_large(problem) and (not fabric.is_plain or len(fabric.pes) > _LARGE_ARRAY)


def gain_foothold(campaign: Campaign, limit: int) -> None:
    """A mapping by negotiation; where that finds none by the kernel mobility schedule."""
    campaign.request = gain_by_negotiation(campaign, limit)
    if campaign.best is None:
        _by_mobility(campaign, limit)


def _by_mobility(campaign: Campaign, limit: int) -> None:
    """The first of some IIs from the bound on, each with a share of the time."""
    deadline = campaign.request.deadline
    iis = dict.fromkeys(min(math.ceil(step * campaign.lower), limit) for step in _STEPS)
    for ii in iis:
        share = deadline.within(_STEP_SHARE * deadline.remaining_s)
        campaign.note(ii, map_by_mobility(campaign.problem, ii, campaign.request, share, 0))
        if campaign.best is not None or deadline.passed:
            return
