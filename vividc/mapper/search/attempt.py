"""One II: the ways to map it or to refute it, from the cheapest to the complete one."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.mapper.bounds.refutations import BY_FOLDING, BY_MODEL, BY_SCHEDULE, WITHIN_ADDED
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat import (
    Extension,
    Prepared,
    ScheduleOptions,
    Search,
    complete_slack,
    fixed,
    folded,
    place_and_route,
    refute_folded,
    refute_schedule,
    schedule,
    windowed,
)
from vividc.mapper.engines.negotiate import Effort, negotiate
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.resources.plain_core import named_anew, unrotated

MAX_MODEL_SIZE = 600_000
"""Booleans beyond which a model is not built: memory, and presolve would not stop in time."""

_VARIABLES_PER_S = 30_000
"""Booleans built and presolved in a second, cautiously (building alone: 100,000 on one core)."""

_SCHEDULE_S = 1.0
_SCHEDULE_S_PER_NODE = 0.02
_ROUTE_S = 2.0
_ROUTE_S_PER_NODE = 0.1
_WIDEN_AFTER = 4
_MOST_DOUBLINGS = 16
_LARGE = 40
_SIDES = 2
"""Annealings with seeds of their own that go on in step."""
_KINDS = ((1, 0), (2, 1), (3, 2), (0, 0))
"""(cycles a word may live at no cost, stages that the schedule may be longer than needed)."""


@dataclass(frozen=True, slots=True)
class Attempt:
    """What became of one II: a mapping, a refutation (`refuted_by`), or neither."""

    mapping: Mapping | None = None
    refuted_by: str | None = None

    @property
    def decided(self) -> bool:
        """Mapped or refuted."""
        return self.mapping is not None or self.refuted_by is not None


OPEN = Attempt()


def refute_cheaply(task: MapProblem, ii: int, request: MapRequest, deadline: Deadline) -> Attempt:
    """Modulo scheduling without places, first with short schedules: those that exist are found
    faster there.
    """
    half = deadline.within(deadline.remaining_s / 2)
    any_schedule = ScheduleOptions(slack=ii, carry=False)
    search = Search(half, request.workers, light=True)
    if schedule(task, ii, any_schedule, search).verdict == "found" or deadline.passed:
        return OPEN
    outcome = refute_schedule(task, ii, Search(deadline, request.workers))
    if outcome.verdict == "refuted":
        return Attempt(refuted_by=BY_SCHEDULE)
    return OPEN


def map_decoupled(
    task: MapProblem, ii: int, request: MapRequest, deadline: Deadline, first_seed: int = 0
) -> Attempt:
    """Schedules first, then places and routes with times fixed, later nearly so; several schedules
    until one routes.
    """
    seed = first_seed
    seen: list[dict[int, int]] = []
    while not deadline.passed:
        start = _schedule(task, ii, request, deadline, seed)
        seed += 1
        if start is None or start in seen:
            if seed - first_seed > 3 * (len(seen) + 1):
                break
            continue
        seen.append(start)
        slack = seed // _WIDEN_AFTER % 2
        request.tell(f"II {ii}: placing and routing schedule {len(seen)}, slack {slack}")
        budget_s = _ROUTE_S + len(task.dfg.placed) * _ROUTE_S_PER_NODE
        turn = min(seed // len(_KINDS), _MOST_DOUBLINGS)
        share = deadline.within(budget_s * 2**turn)
        search = Search(share, 1, seed, light=True, jumps=False)
        attempt = _joint(fixed(task, ii, start, slack), search, request.extend)
        if attempt.mapping is not None:
            return attempt
    return OPEN


def map_negotiated(
    task: MapProblem,
    ii: int,
    request: MapRequest,
    deadline: Deadline,
    seed: int,
    effort: Effort | None = None,
) -> Attempt:
    """Annealed places and negotiated routes, without a solver: for large graphs."""
    request.tell(f"II {ii}: annealing places, negotiating routes")
    core = replace(task, fabric=unrotated(task.fabric))
    mapping = negotiate(core, ii, seed, deadline, effort, _SIDES, request.workers)
    return OPEN if mapping is None else Attempt(mapping=named_anew(task, mapping))


def is_large(task: MapProblem) -> bool:
    """Whether placing and routing by constraints takes longer than by negotiation."""
    return len(task.dfg.placed) >= _LARGE


def refute_by_folding(
    task: MapProblem, ii: int, request: MapRequest, deadline: Deadline
) -> Attempt:
    """Place and route in slots instead of times: no schedule, however long, can do what this
    cannot.
    """
    problem = folded(task, ii)
    if not _buildable(problem, deadline):
        return OPEN
    request.tell(f"II {ii}: solving the cyclic relaxation")
    if refute_folded(problem, Search(deadline, request.workers)).verdict == "refuted":
        return Attempt(refuted_by=BY_FOLDING)
    return OPEN


def map_jointly(task: MapProblem, ii: int, request: MapRequest, deadline: Deadline) -> Attempt:
    """Time, place and route in one model, with windows that grow until they are complete."""
    complete = complete_slack(task, ii)
    if request.extend is not None:  # what is added may ask for longer schedules: all of them
        complete = ii * task.fabric.controller.max_stages
    slack = min(max(ii // 2, 1), complete)
    problem = windowed(task, ii, slack)
    if slack > 1 and not _buildable(problem, deadline):
        slack, problem = 1, windowed(task, ii, 1)
    while not deadline.passed and _buildable(problem, deadline):
        request.tell(f"II {ii}: joint model with slack {slack}, {problem.size} Booleans")
        if slack >= complete:
            return _joint(problem, Search(deadline, request.workers), request.extend)
        slack = min(2 * slack, complete)
        wider, half = windowed(task, ii, slack), deadline.within(deadline.remaining_s / 2)
        share = half if _buildable(wider, half) else deadline
        attempt = _joint(problem, Search(share, request.workers, light=True), request.extend)
        if attempt.mapping is not None:
            return attempt
        problem = wider
    return OPEN


def _schedule(
    task: MapProblem, ii: int, request: MapRequest, deadline: Deadline, seed: int
) -> dict[int, int] | None:
    options = _options(ii, seed)
    budget_s = _SCHEDULE_S + len(task.dfg.placed) * _SCHEDULE_S_PER_NODE
    budget = deadline.within(min(budget_s, deadline.remaining_s / 2))
    return schedule(task, ii, options, Search(budget, request.workers, seed, light=True)).value


def _options(ii: int, seed: int) -> ScheduleOptions:
    """Which schedule to try next: tight and loose in turn, either may be the one that routes."""
    easy_life, stages = _KINDS[seed % len(_KINDS)]
    turn = seed // len(_KINDS)
    slack = 2 if stages == 0 else stages * ii
    return ScheduleOptions(easy_life, slack, turn, spread=turn % 2 == 0)


def _joint(problem: Prepared, search: Search, extend: Extension | None) -> Attempt:
    """ "Refuted" is passed on for all windows alike; only complete ones may use it."""
    if not _buildable(problem, search.deadline):
        return OPEN
    outcome = place_and_route(problem, search, extend=extend)
    if outcome.value is not None:
        return Attempt(mapping=outcome.value)
    if outcome.verdict == "refuted":
        return Attempt(refuted_by=BY_MODEL if extend is None else BY_MODEL + WITHIN_ADDED)
    return OPEN


def _buildable(problem: Prepared, deadline: Deadline) -> bool:
    affordable = min(_VARIABLES_PER_S * deadline.remaining_s, MAX_MODEL_SIZE)
    return problem.least_size <= affordable and problem.size <= affordable
