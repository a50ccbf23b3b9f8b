"""The walk over IIs by a strategy's own steps: upward from the bound until one maps, then the IIs
below the incumbent, or one II only.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vividc.mapper.deadline import Deadline
from vividc.mapper.request import MapRequest
from vividc.mapper.search.attempt import refute_cheaply
from vividc.mapper.search.state import IISearch, ii_limit
from vividc.mapper.search.tuning import (
    CLIMB_LEAST_S,
    CLIMB_SHARE,
    FAILURES_PER_STEP,
    LONG_CLIMB_FIRST_SHARE,
    LONG_CLIMB_SHARE,
    MOST_DOUBLINGS,
    PATIENCES,
    WORTH_TRYING_S,
)


def first_turn(request: MapRequest) -> Deadline:
    """Of one II on the way upward: a share of the time where the effort is to prove."""
    if request.effort != "prove":
        return request.deadline.within(PATIENCES[request.effort].turn_s)
    share_s = CLIMB_SHARE * request.deadline.remaining_s
    return request.deadline.within(max(CLIMB_LEAST_S, share_s))


def climb_in_short_turns(search: IISearch) -> None:
    """Climb with a small share of the time for each II, which doubles from round to round."""
    turn_s = first_turn(search.request).remaining_s
    _climb_until_mapped(search, lambda round_, _: turn_s * 2 ** min(round_, MOST_DOUBLINGS))


def climb_in_long_turns(search: IISearch) -> None:
    """Climb with a large share for each II, where no other phase comes to it again."""
    total_s = search.request.deadline.remaining_s

    def turn_s(_: int, failures: int) -> float:
        share = LONG_CLIMB_SHARE if failures else LONG_CLIMB_FIRST_SHARE
        return max(CLIMB_LEAST_S, share * total_s)

    _climb_until_mapped(search, turn_s)


def _climb_until_mapped(search: IISearch, turn_s: Callable[[int, int], float]) -> None:
    """Upward from the bound again and again, until an II maps, none is left, or the attempts return
    at once. `turn_s`: seconds for an II, by round and failures in it.
    """
    deadline, round_ = search.request.deadline, 0
    while True:
        before_s = deadline.remaining_s
        climb(search, partial(turn_s, round_))
        spent_s = before_s - deadline.remaining_s
        if search.incumbent is not None or deadline.passed or spent_s < WORTH_TRYING_S:
            return
        round_ += 1


def climb(search: IISearch, turn_s: Callable[[int], float]) -> None:
    """Upward from the bound once, each II for `turn_s` seconds by the failures before it. Steps
    grow after failures, so that some II maps. The only II that is left gets all the time. Below an
    incumbent the bound, if it was tried before, waits for the next round.
    """
    deadline, incumbent = search.request.deadline, search.incumbent
    limit = ii_limit(search.problem) if incumbent is None else incumbent.ii - 1
    ii, failures = search.lower, 0
    if incumbent is not None and ii < limit and search.tries.get(ii, 0) > 0:
        ii += 1
    while ii <= limit and not deadline.passed:
        only = incumbent is None and search.lower == limit
        share_s = deadline.remaining_s if only else turn_s(failures)
        attempt = search.try_ii(ii, deadline.within(share_s))
        if attempt.mapping is not None:
            return
        if attempt.refuted_by is None:
            failures += 1
        ii = max(ii + 1 + failures // FAILURES_PER_STEP, search.lower)


def descend(search: IISearch) -> None:
    """Spend what is left on the IIs below the incumbent's: map the largest, refute the rest; rounds
    get longer.
    """
    while search.incumbent is not None:
        deadline, pending = search.deadline, search.open_iis()
        if not pending or deadline.remaining_s < WORTH_TRYING_S:
            return
        before_s = deadline.remaining_s
        share_s = before_s if len(pending) == 1 else before_s / (len(pending) + 1)
        for ii in reversed(pending):
            if ii < search.incumbent.ii:
                search.try_ii(ii, deadline.within(share_s))
        idle = before_s - deadline.remaining_s < WORTH_TRYING_S
        if idle and len(search.open_iis()) == len(pending):
            return


def try_only_once(search: IISearch) -> None:
    """One try of the II that is asked for."""
    search.try_ii(search.only_ii, search.request.deadline)


def try_only(search: IISearch) -> None:
    """The II that is asked for, until it is decided, time is up, or attempts return at once."""
    deadline, ii = search.request.deadline, search.only_ii
    while search.incumbent is None and ii not in search.refuted and not deadline.passed:
        before_s = deadline.remaining_s
        search.try_ii(ii, deadline)
        if before_s - deadline.remaining_s < WORTH_TRYING_S:
            return


def refute_below(search: IISearch) -> None:
    """Below an II that was asked for and maps, raise the bound by schedules without places."""
    while search.incumbent is not None and search.lower < search.only_ii:
        deadline = search.deadline
        if deadline.passed:
            return
        attempt = refute_cheaply(search.problem, search.lower, search.request, deadline)
        if attempt.refuted_by is None:
            return
        search.refuted[search.lower] = attempt.refuted_by
        search.lower += 1
