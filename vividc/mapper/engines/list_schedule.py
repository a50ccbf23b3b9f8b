"""List scheduling of straight regions: place and route each node as early as the array allows.

The classic greedy (Graham 1966; heights as priorities: Coffman 1976, chapter 2), with routing as
part of the placement, and repeated with the priority of late nodes raised (squeaky wheel: Joslin
and Clements 1999). Words that wait keep a register, so a placement can always be completed later
(see `greedy.words`); it fails when registers or constant stores are full, or when a PE can bring
together fewer words than an operation reads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from vividc.mapper.bounds.straight import heights_of, straight_lower_bound
from vividc.mapper.engines.greedy import Policy, Region, Schedule
from vividc.mapper.engines.refusals import (
    Stuck,
    failure_of,
    refuse_impossible,
    refuse_too_long,
)
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import NO_MEETS, Meets

__all__ = ["list_schedule", "straight_lower_bound"]

_NODES_IN_ALL_TRIALS: Final = 1200
_MAX_TRIALS: Final = 24
_MANY: Final = 600
"""More have two trials: a third takes a second or more (830 operations of correlation), and maps
nothing where two did not.
"""
_NEAR: Final = 100
"""Cycles of the bound, for each of which a schedule that ends the trials may be a cycle longer: the
second trial of 612 operations (trisolv, 230.9 cycles at a bound of 229) takes a second and comes to
more.
"""
_SPARED: Final = 12
"""Entries of constant stores: a store or load, its address and a number take three."""

_APART: Final = (2, 4, 1)
"""By trial."""


def list_schedule(
    problem: MapProblem,
    goes_on: Callable[[], bool] = lambda: True,
    *,
    frugal: bool = False,
    meets: Meets = NO_MEETS,
) -> Mapping:
    """A legal schedule of a straight region; its `ii` is the length in cycles (1 or more).

    Deterministic, but for what `goes_on` says. The length is minimal when it equals
    `straight_lower_bound(problem).ii`; it may be longer where accesses meet in fewer banks for it.

    Parameters
    ----------
    goes_on
        Whether a shorter one is to be tried for, asked when there is one.
    frugal
        Rather longer than with entries in constant stores that are nearly full, which regions
        scheduled later need.
    meets
        How often each two accesses of one cycle meet in a bank.

    Raises
    ------
    MappingFailed
        A node fits no PE, the words alive do not fit the registers, or the region is longer than
        the configuration memory.
    TimeLimit
        Time is up (`time_limit`).
    """
    refuse_impossible(problem)
    bound = straight_lower_bound(problem)
    refuse_too_long(problem, bound.ii)
    region = Region(problem, heights_of(problem), meets)
    urgency: dict[int, int] = {}
    best: Schedule | None = None
    least = math.inf
    failure: Stuck | None = None
    trials = _trials(problem)
    for trial in range(trials):
        policy = _policy(trial, urgency, failure is not None, frugal)
        schedule = Schedule(region, policy)
        try:
            length = schedule.run(least if trial == trials - 1 else math.inf)
        except Stuck as stuck:
            failure = stuck
            continue
        if length is None:
            break
        cycles = length + schedule.waits
        if best is None or cycles < least:
            best, least = schedule, cycles
        if least < bound.ii + 1 + bound.ii // _NEAR or not goes_on():
            break
        urgency = _raised(urgency, schedule, bound.ii)
    if best is None:
        raise failure_of(problem, failure)
    mapping = best.mapping()
    refuse_too_long(problem, mapping.ii)
    return mapping


def _trials(problem: MapProblem) -> int:
    nodes = len(problem.dfg.placed)
    least = 2 if nodes > _MANY else 3
    return max(least, min(_MAX_TRIALS, _NODES_IN_ALL_TRIALS // max(1, nodes)))


# --- trials ---------------------------------------------------------------------------------------


def _policy(trial: int, urgency: dict[int, int], crowded: bool, frugal: bool) -> Policy:
    deep = crowded and trial % 2 == 1
    return Policy(
        urgency,
        pressure=0.0 if deep else 0.25 if crowded else 0.6,
        deep=deep,
        affinity=(2, 0, 4)[trial % 3],
        constants=8 if crowded or frugal else 1,
        spared=_SPARED if frugal else 0,
        apart=_APART[trial % len(_APART)],
    )


def _raised(urgency: dict[int, int], schedule: Schedule, target: int) -> dict[int, int]:
    """Raise the priority of nodes that make the schedule longer than `target`, by the excess."""
    raised, heights = dict(urgency), schedule.region.heights
    for node, start in schedule.starts().items():
        late = start + heights.of[node] - target
        if late > 0:
            raised[node] = raised.get(node, 0) + late
    return raised
