"""One II: the ways to refute it or to map it, from the cheapest to the complete one."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from vividc.mapper.bounds.refutations import BY_FOLDING, BY_MODEL, BY_SCHEDULE, WITHIN_ADDED
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines import cpsat
from vividc.mapper.engines.negotiate import Effort, least_span, negotiate, tight_frame
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.resources.plain_core import named_anew, unrotated
from vividc.mapper.search.state import OPEN, Attempt, is_large
from vividc.mapper.search.tuning import (
    BOOLEANS_PER_S,
    LARGE_ARRAY,
    MOST_BOOLEANS,
    MOST_DOUBLINGS,
    PATIENCES,
    ROUTE_S,
    ROUTE_S_PER_NODE,
    SCHEDULE_KINDS,
    SCHEDULE_S,
    SCHEDULE_S_PER_NODE,
    SCHEDULED_SHARE,
    SCHEDULED_SHARE_TO_PROVE,
    SECOND_SEED,
    SEEDS_IN_STEP,
    WIDEN_AFTER,
)

_SCHEDULES_PER_ROUND: Final = 1000
"""Seeds of one round of `map_decoupled`."""


def needs_warm_start(problem: MapProblem) -> bool:
    """Whether constraints may take all the time there is on the way upward from the bound, of a
    small graph: on large arrays, and where words do not only take links.
    """
    fabric = problem.fabric
    return not is_large(problem) and (not fabric.is_plain or len(fabric.pes) > LARGE_ARRAY)


def refute_cheaply(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline
) -> Attempt:
    """Modulo scheduling without places, first with short schedules, which are found faster where
    there are any.
    """
    share = SCHEDULED_SHARE_TO_PROVE if request.effort == "prove" else SCHEDULED_SHARE
    part = deadline.within(deadline.remaining_s * share)
    any_schedule = cpsat.ScheduleOptions(slack=ii, carry=False)
    search = cpsat.Search(part, request.workers, light=True)
    if cpsat.schedule(problem, ii, any_schedule, search).verdict == "found" or deadline.passed:
        return OPEN
    outcome = cpsat.refute_schedule(problem, ii, cpsat.Search(deadline, request.workers))
    if outcome.verdict == "refuted":
        return Attempt(refuted_by=BY_SCHEDULE)
    return OPEN


def refute_now_and_then(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    """Modulo scheduling without places in the first round and in some of the later ones, which are
    longer: what a short time did not refute a longer one may.
    """
    if tries & (tries + 1):
        return OPEN
    return refute_cheaply(problem, ii, request, deadline)


def map_negotiated(
    problem: MapProblem,
    ii: int,
    request: MapRequest,
    deadline: Deadline,
    seed: int,
    effort: Effort | None = None,
    longer: int | None = None,
) -> Attempt:
    """Anneal places and negotiate routes, without a solver; `longer`: iterations take at most so
    many cycles more than dependences do (none: somewhat more).
    """
    request.tell(f"II {ii}: annealing places, negotiating routes")
    core = replace(problem, fabric=unrotated(problem.fabric))
    frame = None
    if longer is not None:
        frame = tight_frame(core, ii, least_span(core, ii) + longer)
        if frame is None:
            return OPEN
    patience = PATIENCES.get(request.effort)
    if patience is not None and patience.quits:
        effort = replace(effort or Effort(), quits=True)
    made = negotiate(core, ii, seed, deadline, effort, SEEDS_IN_STEP, request.workers, frame=frame)
    if made.mapping is None:
        return Attempt(is_far=made.is_far and longer is None)
    return Attempt(mapping=named_anew(problem, made.mapping))


def map_negotiated_if_slow(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    """The same for small graphs, where constraints may take long; one seed a round."""
    if not needs_warm_start(problem):
        return OPEN
    return map_negotiated(problem, ii, request, deadline, SECOND_SEED + tries)


def map_decoupled(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int = 0
) -> Attempt:
    """Schedules first, then places and routes with times fixed, later nearly so; several schedules
    until one routes.
    """
    seed = first_seed = _SCHEDULES_PER_ROUND * tries
    seen: list[dict[int, int]] = []
    while not deadline.passed:
        start = _schedule(problem, ii, request, deadline, seed)
        seed += 1
        if start is None or start in seen:
            if seed - first_seed > 3 * (len(seen) + 1):
                break
            continue
        seen.append(start)
        slack = seed // WIDEN_AFTER % 2
        request.tell(f"II {ii}: placing and routing schedule {len(seen)}, slack {slack}")
        budget_s = ROUTE_S + len(problem.dfg.placed) * ROUTE_S_PER_NODE
        turn = min(seed // len(SCHEDULE_KINDS), MOST_DOUBLINGS)
        share = deadline.within(budget_s * 2**turn)
        search = cpsat.Search(share, 1, seed, light=True, jumps=False)
        attempt = _joint(cpsat.fixed(problem, ii, start, slack), search, request.extend)
        if attempt.mapping is not None:
            return attempt
    return OPEN


def refute_by_folding(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, _: int = 0
) -> Attempt:
    """Place and route in slots instead of times: what has no solution there has no schedule,
    however long.
    """
    model = cpsat.folded(problem, ii)
    if not _buildable(model, deadline):
        return OPEN
    request.tell(f"II {ii}: solving the cyclic relaxation")
    if cpsat.refute_folded(model, cpsat.Search(deadline, request.workers)).verdict == "refuted":
        return Attempt(refuted_by=BY_FOLDING)
    return OPEN


def map_jointly(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, _: int = 0
) -> Attempt:
    """Time, place and route in one model, with windows that grow until they are complete."""
    complete = cpsat.complete_slack(problem, ii)
    if request.extend is not None:  # what is added may ask for longer schedules: all of them
        complete = ii * problem.fabric.controller.max_stages
    slack = min(max(ii // 2, 1), complete)
    model = cpsat.windowed(problem, ii, slack)
    if slack > 1 and not _buildable(model, deadline):
        slack, model = 1, cpsat.windowed(problem, ii, 1)
    while not deadline.passed and _buildable(model, deadline):
        request.tell(f"II {ii}: joint model with slack {slack}, {model.size} Booleans")
        if slack >= complete:
            return _joint(model, cpsat.Search(deadline, request.workers), request.extend)
        slack = min(2 * slack, complete)
        wider, half = cpsat.windowed(problem, ii, slack), deadline.within(deadline.remaining_s / 2)
        share = half if _buildable(wider, half) else deadline
        attempt = _joint(model, cpsat.Search(share, request.workers, light=True), request.extend)
        if attempt.mapping is not None:
            return attempt
        model = wider
    return OPEN


def _schedule(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, seed: int
) -> dict[int, int] | None:
    options = _options(ii, seed)
    budget_s = SCHEDULE_S + len(problem.dfg.placed) * SCHEDULE_S_PER_NODE
    budget = deadline.within(min(budget_s, deadline.remaining_s / 2))
    return cpsat.schedule(
        problem, ii, options, cpsat.Search(budget, request.workers, seed, light=True)
    ).value


def _options(ii: int, seed: int) -> cpsat.ScheduleOptions:
    """Which schedule to try next: tight and loose in turn, either may be the one that routes."""
    easy_life, stages = SCHEDULE_KINDS[seed % len(SCHEDULE_KINDS)]
    turn = seed // len(SCHEDULE_KINDS)
    slack = 2 if stages == 0 else stages * ii
    return cpsat.ScheduleOptions(easy_life, slack, turn, spread=turn % 2 == 0)


def _joint(model: cpsat.Prepared, search: cpsat.Search, extend: cpsat.Extension | None) -> Attempt:
    """What the solver says of the model; a refutation holds for its windows only, so that only a
    caller whose windows are complete may pass it on.
    """
    if not _buildable(model, search.deadline):
        return OPEN
    outcome = cpsat.place_and_route(model, search, extend=extend)
    if outcome.value is not None:
        return Attempt(mapping=outcome.value)
    if outcome.verdict == "refuted":
        return Attempt(refuted_by=BY_MODEL if extend is None else BY_MODEL + WITHIN_ADDED)
    return OPEN


def _buildable(model: cpsat.Prepared, deadline: Deadline) -> bool:
    affordable = min(BOOLEANS_PER_S * deadline.remaining_s, MOST_BOOLEANS)
    return model.least_size <= affordable and model.size <= affordable
