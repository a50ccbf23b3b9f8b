"""Finds the least II: upward from the MII until one maps, then back down while time is left."""

from __future__ import annotations

import time

from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import prepare
from vividc.mapper.mapping import Bound, Refutation, Status
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import Mapper, MapRequest
from vividc.mapper.resources.distances import hop_distances
from vividc.mapper.result import MapInterrupted, MapResult
from vividc.mapper.search.attempt import (
    OPEN,
    Attempt,
    is_large,
    map_decoupled,
    map_jointly,
    map_negotiated,
    refute_by_folding,
    refute_cheaply,
)
from vividc.mapper.search.campaign import Campaign, Strategy
from vividc.mapper.search.foothold import gain_foothold, needs_foothold
from vividc.mapper.search.large import descend_large, insist, limit_of, start_large, try_only
from vividc.mapper.search.windows import search_windows, start_in_window

_CLIMB_SHARE = 0.08
_FIRST_SHARE_ALONE, _CLIMB_SHARE_ALONE = 0.5, 0.2
"""Where constraints alone are to find a mapping: no other strategy comes to an II again."""
_CLIMB_LEAST_S = 2.0
_FIRST_SHARE = 0.5
_WORTH_TRYING_S = 0.3
_PROOF_SHARE = 0.15
_NEGOTIATION_SHARE = 0.4
_FIRST_SEED = 2
"""A foothold is negotiated with the seed before."""


def auto(problem: MapProblem, request: MapRequest) -> MapResult:
    """Every way: negotiation where constraints take long, schedules before places, relaxations, the
    joint model, and windows of the array.
    """
    return _search(problem, request, "auto", _try_everything, in_window=_auto_in_window)


def _auto_in_window(problem: MapProblem, request: MapRequest) -> MapResult:
    return _search(problem, request, "auto", _try_everything)


def cpsat(problem: MapProblem, request: MapRequest) -> MapResult:
    """The joint model, with the bounds and the scheduling relaxation before it; of large graphs
    some mapping comes from negotiation, for the model to better.
    """
    return _search(problem, request, "cpsat", _try_jointly)


def decoupled(problem: MapProblem, request: MapRequest) -> MapResult:
    """Schedule first, then place and route, graphs of any size, on large arrays in windows first;
    "optimal" only where bounds and the relaxation prove it.
    """
    return _search(problem, request, "decoupled", _try_decoupled, in_window=_decoupled_in_window)


def _decoupled_in_window(problem: MapProblem, request: MapRequest) -> MapResult:
    return _search(problem, request, "decoupled", _try_decoupled)


def ii_limit(problem: MapProblem) -> int:
    """An II beyond which trying makes no sense: all operations one after another, each as far as
    the array is wide.
    """
    hops = hop_distances(problem.fabric)
    reachable = [d for row in hops for d in row if d < len(hops)]
    step = max(reachable, default=0) + problem.fabric.controller.control_latency + 1
    length = sum(problem.fabric.latency(node) + step for node in problem.dfg.placed)
    return min(problem.fabric.controller.contexts, max(length, 1))


def _search(
    problem: MapProblem,
    request: MapRequest,
    name: str,
    strategy: Strategy,
    *,
    in_window: Mapper | None = None,
) -> MapResult:
    began = time.monotonic()
    bounds = all_bounds(problem)
    large = _negotiates(problem, request, strategy)
    small = _takes_footholds(problem, request, strategy)
    if (large or (small and needs_foothold(problem))) and mii(bounds) < no_ii(problem):
        prepare(request.tell)
    campaign = Campaign(problem, request, strategy, mii(bounds), request.known)
    try:
        infeasible = _explore(campaign, in_window)
    except KeyboardInterrupt as stop:
        if campaign.best is None:
            raise
        result = result_of(campaign, bounds, name, began, infeasible=False)
        raise MapInterrupted(result) from stop
    return result_of(campaign, bounds, name, began, infeasible=infeasible)


def _explore(campaign: Campaign, in_window: Mapper | None) -> bool:
    """Search until the deadline or the proof, with `in_window` on rectangles of a large array;
    whether no II maps.
    """
    problem, request, strategy = campaign.problem, campaign.request, campaign.strategy
    if campaign.lower >= no_ii(problem):
        return True
    if request.ii is not None:
        return _only(campaign, request.ii)
    large = _negotiates(problem, request, strategy)
    jointly = strategy is _try_jointly
    if large and in_window is not None:
        start_in_window(campaign)
    if large:
        start_large(campaign, ii_limit(problem))
    elif _takes_footholds(problem, request, strategy):
        _start_small(campaign)
    if large and not jointly:
        descend_large(campaign)
    others = iter(()) if in_window is None else search_windows(campaign, in_window)
    if large and not jointly:
        insist(campaign, others)
    for _ in others:
        pass
    if campaign.best is None or jointly or not large:
        _climb_until_mapped(campaign)
        _descend(campaign)
    return campaign.best is None and campaign.lower >= no_ii(problem)


def _negotiates(problem: MapProblem, request: MapRequest, strategy: Strategy) -> bool:
    """Whether negotiation comes first: it knows no constraints of a caller's, and has no part in
    the mapper that is named for its schedules.
    """
    return is_large(problem) and request.extend is None and strategy is not _try_decoupled


def _takes_footholds(problem: MapProblem, request: MapRequest, strategy: Strategy) -> bool:
    """Whether negotiation takes part in the search of a small graph, too."""
    return strategy is _try_everything and not is_large(problem) and request.extend is None


def _start_small(campaign: Campaign) -> None:
    """Some mapping soon. Where words take links, constraints often map at the bound at once; where
    they do not, the way upward from there is long.
    """
    limit = ii_limit(campaign.problem)
    if not needs_foothold(campaign.problem):
        half = _part(campaign.request.deadline, _FIRST_SHARE)
        campaign.try_ii(campaign.lower, half.within(_turn(campaign.request).remaining_s))
    if campaign.best is None and campaign.lower <= limit:
        gain_foothold(campaign, limit)


def _only(campaign: Campaign, ii: int) -> bool:
    """Try one II only, with all the time there is; whether it was refuted."""
    if campaign.is_ruled_out(ii):
        return True
    jointly = campaign.strategy is _try_jointly
    if _negotiates(campaign.problem, campaign.request, campaign.strategy) and not jointly:
        try_only(campaign, ii)
    elif _takes_footholds(campaign.problem, campaign.request, campaign.strategy):
        _try_small(campaign, ii)
    deadline = campaign.request.deadline
    while campaign.best is None and ii not in campaign.refuted and not deadline.passed:
        before = deadline.remaining_s
        campaign.try_ii(ii, deadline)
        if before - deadline.remaining_s < _WORTH_TRYING_S:
            break
    if campaign.best is not None:
        _refute_below(campaign, ii)
    return ii in campaign.refuted


def _try_small(campaign: Campaign, ii: int) -> None:
    """One II by constraints for a turn, then by negotiation: where it is far above the bound, many
    slots make constraints slow.
    """
    if campaign.try_ii(ii, _turn(campaign.request)).decided:
        return
    prepare(campaign.request.tell)
    try_only(campaign, ii)


def _refute_below(campaign: Campaign, ii: int) -> None:
    while campaign.lower < ii:
        lower = campaign.lower
        attempt = refute_cheaply(
            campaign.problem, lower, campaign.request, campaign.request.deadline
        )
        if attempt.refuted_by is None:
            return
        campaign.refuted[lower] = attempt.refuted_by
        campaign.lower += 1


def _climb_until_mapped(campaign: Campaign) -> None:
    """Upward from the MII again and again, each time with twice the time for an II, until one maps,
    none is left or trying takes no time any more.
    """
    deadline = campaign.request.deadline
    total_s, turn_s = deadline.remaining_s, _turn(campaign.request).remaining_s
    while True:
        before_s = deadline.remaining_s
        climb(campaign, total_s, turn_s)
        spent_s = before_s - deadline.remaining_s
        if campaign.best is not None or deadline.passed or spent_s < _WORTH_TRYING_S:
            return
        turn_s *= 2


def climb(campaign: Campaign, total_s: float, turn_s: float) -> None:
    """Upward from the MII with a share of the time each, which is small: an II that takes longer is
    tried again from above. Steps grow after failures, so that something is found. The only II that
    is left gets all the time. Below a foothold the bound, just tried, waits for the IIs between.
    """
    deadline = campaign.request.deadline
    alone = campaign.strategy is not _try_everything
    best = campaign.best
    limit = ii_limit(campaign.problem) if best is None else best.ii - 1
    ii, failures = campaign.lower, 0
    if best is not None and ii < limit and campaign.tries.get(ii, 0) > 0:
        ii += 1
    while ii <= limit and not deadline.passed:
        share = _CLIMB_SHARE_ALONE if failures else _FIRST_SHARE_ALONE
        share_s = max(_CLIMB_LEAST_S, share * total_s) if alone else turn_s
        if best is None and campaign.lower == limit:
            share_s = deadline.remaining_s
        attempt = campaign.try_ii(ii, deadline.within(share_s))
        if attempt.mapping is not None:
            return
        if attempt.refuted_by is None:
            failures += 1
        ii = max(ii + 1 + failures // 3, campaign.lower)


def _turn(request: MapRequest) -> Deadline:
    """Of one II on the way upward: a share of the time, the least that makes sense for a thrifty
    request.
    """
    share_s = 0.0 if request.thrifty else _CLIMB_SHARE * request.deadline.remaining_s
    return request.deadline.within(max(_CLIMB_LEAST_S, share_s))


def _descend(campaign: Campaign) -> None:
    """Spend what is left on the IIs below the best: map the largest, refute the rest; rounds get
    longer. A thrifty request may have enough before (`limit_of`).
    """
    while campaign.best is not None:
        deadline = limit_of(campaign)
        pending = campaign.open_iis()
        if not pending or deadline.remaining_s < _WORTH_TRYING_S:
            return
        before = (len(pending), deadline.remaining_s)
        share = deadline.remaining_s / (len(pending) + 1)
        if len(pending) == 1:
            share = deadline.remaining_s
        for ii in reversed(pending):
            if ii < campaign.best.ii:
                campaign.try_ii(ii, deadline.within(share))
        idle = before[1] - deadline.remaining_s < _WORTH_TRYING_S
        if idle and len(campaign.open_iis()) == before[0]:
            return


def _try_everything(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    attempt = _refute_again(problem, ii, request, deadline, tries)
    if not attempt.decided and needs_foothold(problem) and request.extend is None:
        part = _part(deadline, _NEGOTIATION_SHARE)
        attempt = map_negotiated(problem, ii, request, part, _FIRST_SEED + tries)
    if not attempt.decided:
        attempt = map_decoupled(problem, ii, request, _part(deadline, 0.7), 1000 * tries)
    if not attempt.decided:
        attempt = refute_by_folding(problem, ii, request, _part(deadline, 0.4))
    if not attempt.decided:
        attempt = map_jointly(problem, ii, request, deadline)
    return attempt


def _try_jointly(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    attempt = _refute_again(problem, ii, request, deadline, tries)
    if not attempt.decided:
        attempt = map_jointly(problem, ii, request, deadline)
    return attempt


def _try_decoupled(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    attempt = _refute_again(problem, ii, request, deadline, tries)
    if not attempt.decided:
        attempt = map_decoupled(problem, ii, request, deadline, 1000 * tries)
    return attempt


def _refute_again(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    """Scheduling without places in the first round and in some of the later ones, which are longer:
    what a short time did not refute a longer one may.
    """
    if tries & (tries + 1):
        return OPEN
    return refute_cheaply(problem, ii, request, _part(deadline, _PROOF_SHARE))


def _part(deadline: Deadline, share: float) -> Deadline:
    return deadline.within(deadline.remaining_s * share)


def result_of(
    campaign: Campaign, bounds: tuple[Bound, ...], name: str, began: float, *, infeasible: bool
) -> MapResult:
    """What a finished search has to say."""
    best = campaign.best
    refuted = [Refutation(ii, by) for ii, by in sorted(campaign.refuted.items())]
    return MapResult(
        status=_status(campaign, infeasible=infeasible),
        ii=None if best is None else best.ii,
        lower_bound=campaign.lower,
        bounds=bounds,
        mapping=best,
        mapper=name,
        wall_s=time.monotonic() - began,
        refuted=tuple(item for item in refuted if best is None or item.ii < best.ii),
        stats={
            "tries": float(sum(campaign.tries.values())),
            "found_s": campaign.improved_s - campaign.began_s,
        },
        constrained=campaign.request.extend is not None,
    )


def _status(campaign: Campaign, *, infeasible: bool) -> Status:
    if infeasible:
        return "infeasible"
    if campaign.best is None:
        return "timeout"
    return "optimal" if campaign.lower >= campaign.best.ii else "feasible"
