"""Large graphs: some mapping soon, then smaller IIs by negotiation, then proofs for what is left.

Each step has a fixed effort and a fixed seed, and a deadline only cuts the sequence off: a longer
time limit goes the same way farther. The limit does not count the one compilation of the annealer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, prepare
from vividc.mapper.problem import MapProblem
from vividc.mapper.request import MapRequest
from vividc.mapper.search.attempt import Attempt, map_negotiated, refute_cheaply
from vividc.mapper.search.campaign import Campaign

QUICK: Final = Effort(moves=3000, rounds=30, repairs=60, trials=1, shown=1)
_DESCENTS: Final = (Effort(trials=1), Effort())
_DESCENTS_WITH_MOVES: Final = (
    Effort(moves=4000, repairs=60, shown=1),
    Effort(moves=4000, repairs=60),
    Effort(),
    Effort(moves=16000),
)
"""Of each round from the best downward: where FUs move words, what fails takes longest."""
_STEP, _STEP_WITH_MOVES, _LARGE_STEP_WITH_MOVES = 1 / 24, 1 / 4, 1.0
"""The first step above the bound, in bounds (the last one: on large arrays). Where FUs move words
the best II is farther above it, and what fails takes longest.
"""
_SHARE, _BOUND_SHARE_WITH_MOVES = 0.4, 0.1
"""Of the time that is left, for an II until something maps."""
_LARGE_ARRAY: Final = 64
_ROOMY: Final = 0.3
_FIRST_PROOF_S, _PROOF_S = 1.0, 2.0
_HALF, _THIRD = 2, 3
_SEEDS: Final = 3
_SEEDED_NODES: Final = 150
"""Where FUs move words: nodes that the seeds of the first round anneal together, since each seed is
as likely to map as the one before, and the solver is rarely faster.
"""
_SOLVER_S: Final = 400.0
"""Seconds for the solver in the first round, of a graph of one node: it is the better the smaller
the graph.
"""
_NEAR: Final = 1
_FOOTHOLD_SHARE: Final = 0.3
_FOOTHOLD_LEAST_S: Final = 2.0
_PATIENCE_LEAST_S, _PATIENCE_FACTOR = 4.0, 3.0


def start_large(campaign: Campaign, limit: int) -> None:
    """Some mapping by negotiation, from the bound upward; from above it on large arrays whose FUs
    move words, unless there is room enough at the bound.
    """
    if campaign.best is not None:
        return
    fabric = campaign.problem.fabric
    share = _BOUND_SHARE_WITH_MOVES if fabric.routing.moves else _SHARE
    if not _needs_large_steps(fabric) or _is_roomy(campaign):
        _negotiate(campaign, campaign.lower, 1, QUICK, share)
    if campaign.best is None:
        _climb(campaign, limit)


def _needs_large_steps(fabric: Fabric) -> bool:
    return fabric.routing.moves and len(fabric.pes) >= _LARGE_ARRAY


def _is_roomy(campaign: Campaign) -> bool:
    """Whether operations take a small part of the array's slots at the bound."""
    problem = campaign.problem
    return work_of(problem) <= _ROOMY * len(problem.fabric.pes) * campaign.lower


def work_of(problem: MapProblem) -> int:
    """Slots of FUs that the operations take in an iteration."""
    return sum(problem.fabric.occupancy(node) for node in problem.dfg.operations)


def descend_large(campaign: Campaign) -> None:
    """Smaller IIs by negotiation, and the bound as far as it is raised easily."""
    _raise_bound(campaign, _FIRST_PROOF_S)
    moves = campaign.problem.fabric.routing.moves
    for turn, effort in enumerate(_DESCENTS_WITH_MOVES if moves else _DESCENTS):
        _descend(campaign, effort, 1 + turn)
    _raise_bound(campaign, _PROOF_S)


def insist(campaign: Campaign, others: Iterator[None]) -> None:
    """The IIs just below the best, with other seeds and more effort each round, a step of another
    search, and the campaign's own strategy.

    A thrifty request stops when the best is within 1 of the bound and as much time again as three
    times what it took to come there, 4 s at least, has brought nothing: closing such a gap takes a
    proof that rarely ends.
    """
    turn = 0
    while campaign.open_iis() and not _is_enough(campaign):
        ii = campaign.open_iis()[-1]
        turn += 1
        if _try_seeds(campaign, ii, turn):
            turn = 0
            continue
        next(others, None)
        if not campaign.unfinished:
            return
        budget_s = turn * _SOLVER_S / len(campaign.problem.dfg.placed)
        campaign.try_ii(campaign.open_iis()[0], limit_of(campaign).within(budget_s))


def gain_by_negotiation(campaign: Campaign, limit: int) -> MapRequest:
    """Only the first steps, for graphs of any size, after a try at the bound; the request as it
    was.
    """
    request = campaign.request
    prepare(request.tell)
    campaign.request = replace(request, deadline=request.deadline.within(_share(request)))
    if _negotiate(campaign, campaign.lower, 1, QUICK).mapping is not None:
        return request
    _climb(campaign, limit)
    _descend(campaign, Effort())
    return request


def _share(request: MapRequest) -> float:
    return max(_FOOTHOLD_LEAST_S, _FOOTHOLD_SHARE * request.deadline.remaining_s)


def _negotiate(
    campaign: Campaign, ii: int, seed: int, effort: Effort, share: float = 1.0
) -> Attempt:
    """Try an II, with a share of the time that is left at most."""
    request, deadline = campaign.request, limit_of(campaign)
    deadline = deadline.within(share * deadline.remaining_s)
    found = map_negotiated(campaign.problem, ii, request, deadline, seed, effort)
    campaign.note(ii, found)
    return found


def _climb(campaign: Campaign, limit: int) -> None:
    """Some mapping above the bound, each time twice as far above it."""
    fabric = campaign.problem.fabric
    part = _STEP_WITH_MOVES if fabric.routing.moves else _STEP
    part = _LARGE_STEP_WITH_MOVES if _needs_large_steps(fabric) else part
    above = math.ceil(part * campaign.lower)
    while not campaign.request.deadline.passed:
        ii = min(campaign.lower + above, limit)
        share = 1.0 if ii == limit else _SHARE
        if _negotiate(campaign, ii, 1, QUICK, share).mapping is not None or ii == limit:
            return
        above *= 2


def _descend(campaign: Campaign, effort: Effort, seed: int = 1) -> None:
    """Take half of what is open below the best, or a third where FUs move words and most of it will
    fail, as if all above an II that fails would map.
    """
    part = _THIRD if campaign.problem.fabric.routing.moves else _HALF
    low = campaign.lower
    while campaign.best is not None and low < campaign.best.ii:
        if _is_enough(campaign):
            return
        ii = campaign.best.ii - math.ceil((campaign.best.ii - low) / part)
        if _negotiate(campaign, ii, seed, effort).mapping is None:
            low = ii + 1


def _raise_bound(campaign: Campaign, budget_s: float) -> None:
    """Refute from below while that is easy."""
    deadline = campaign.request.deadline
    while campaign.open_iis():
        before = campaign.lower
        budget = deadline.within(budget_s)
        campaign.note(before, refute_cheaply(campaign.problem, before, campaign.request, budget))
        if campaign.lower == before:
            return


def try_only(campaign: Campaign, ii: int) -> None:
    """One II by negotiation, some seeds."""
    for turn in range(1, _SEEDS):
        if campaign.best is None:
            _try_seeds(campaign, ii, turn)


def _try_seeds(campaign: Campaign, ii: int, turn: int) -> bool:
    """Some seeds, with effort that grows; whether one maps."""
    effort = Effort(moves=Effort().moves * (1 + turn // 2), repairs=Effort().repairs * turn)
    for seed in _seeds(campaign, turn):
        if _is_enough(campaign):
            return False
        if _negotiate(campaign, ii, seed, effort).mapping is not None:
            return True
    return False


def _seeds(campaign: Campaign, turn: int) -> range:
    """As many as rounds, up to `_SEEDS`; where FUs move words the more the smaller the graph is."""
    if not campaign.problem.fabric.routing.moves:
        return range(_SEEDS * turn, _SEEDS * turn + min(turn, _SEEDS))
    each = math.ceil(_SEEDED_NODES / len(campaign.problem.dfg.placed))
    first = 1 + len(_DESCENTS_WITH_MOVES) + each * turn * (turn - 1) // 2
    return range(first, first + each * turn)


def _is_enough(campaign: Campaign) -> bool:
    return limit_of(campaign).passed


def limit_of(campaign: Campaign) -> Deadline:
    """The deadline, which a thrifty request brings forward when the gap is small."""
    request, best = campaign.request, campaign.best
    if not request.thrifty or best is None or best.ii - campaign.lower > _NEAR:
        return request.deadline
    reached_s = campaign.improved - campaign.began
    patience_s = max(_PATIENCE_LEAST_S, _PATIENCE_FACTOR * reached_s)
    return replace(request.deadline, at=min(request.deadline.at, campaign.improved + patience_s))
