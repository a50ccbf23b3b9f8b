"""How published mappers search: from the MII upward, the first II that maps is the answer.

Every mapper of this kind brings one function for one II. What it cannot map it has not refuted:
lower bounds come from `bounds` alone, unless the function proves more.
"""

from __future__ import annotations

import time

from vividc.arch.fabric import Fabric
from vividc.errors import VividcError
from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.resources.plain_core import named_anew, plain_core
from vividc.mapper.result import MapResult
from vividc.mapper.search.attempt import Attempt
from vividc.mapper.search.campaign import Campaign, Strategy
from vividc.mapper.search.portfolio import ii_limit, result_of

_SHARE = 0.35
_LEAST_S = 1.0


def search_upward(
    problem: MapProblem, request: MapRequest, name: str, strategy: Strategy
) -> MapResult:
    """Try each II from the MII on, each with a share of the time that is left.

    Past a few failures the steps grow with the II, so that a mapping is found at all.
    """
    began = time.monotonic()
    bounds = all_bounds(problem)
    campaign = Campaign(problem, request, strategy, mii(bounds))
    if campaign.lower >= no_ii(problem):
        return result_of(campaign, bounds, name, began, infeasible=True)
    if request.ii is not None:
        impossible = _try_only(campaign, request.ii)
        return result_of(campaign, bounds, name, began, infeasible=impossible)
    limit = ii_limit(problem)
    ii = campaign.lower
    while ii <= limit and campaign.best is None and not request.deadline.passed:
        share_s = max(_LEAST_S, request.deadline.remaining_s * _SHARE)
        campaign.try_ii(ii, request.deadline.within(share_s))
        ii += 1 + (ii - campaign.lower) // 8
    exhausted = campaign.best is None and campaign.lower >= no_ii(problem)
    return result_of(campaign, bounds, name, began, infeasible=exhausted)


def core_for(fabric: Fabric, name: str) -> Fabric:
    """What of a fabric a router over the MRRG can use.

    Raises
    ------
    VividcError
        Words reach other PEs in ways that the MRRG does not have.
    """
    core = plain_core(fabric)
    if core is None:
        raise VividcError(
            f"mapper {name!r} routes words over links and registers that any word may enter, and "
            f"issues an operation a cycle on each PE; on {fabric.name} {_what_is_else(fabric)}",
            loc="mapper",
            hint="use auto, cpsat, decoupled, sat-kms or spr",
        )
    return core


def _what_is_else(fabric: Fabric) -> str:
    """Why a fabric has no plain core."""
    slow = [kind.value for kind, cycles in fabric.occupancies.items() if cycles > 1]
    if not fabric.routing.hops:
        return "no words take links"
    if slow:
        return f"units are not pipelined ({', '.join(slow)})"
    return "only its own FU writes a PE's registers"


def attempt_of(problem: MapProblem, mapping: Mapping | None) -> Attempt:
    """A mapping to the core of a fabric, in the fabric's own names, as what a try came to."""
    named = None if mapping is None else named_anew(problem, mapping)
    return Attempt(mapping=named)


def _try_only(campaign: Campaign, ii: int) -> bool:
    """Try one II; whether it was refuted."""
    if not campaign.is_ruled_out(ii):
        campaign.try_ii(ii, campaign.request.deadline)
    return ii in campaign.refuted
