"""Chooses the stage of a plan to keep: the most transformed one that maps, unless an earlier one
turns out faster.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vividc.compiler.planning.estimate import Estimate
from vividc.compiler.planning.plan import Plan, Stage
from vividc.dfg.regions import Kernel
from vividc.errors import VividcError
from vividc.mapper.result import MapResult
from vividc.program import Program


@dataclass(frozen=True)
class Outcome:
    """A stage, mapped.

    Attributes
    ----------
    achieved
        The stage's estimate with the mapping's IIs and spans instead of bounds.
    sequential
        Headers of loops that run block by block, with the reason.
    """

    stage: Stage
    kernel: Kernel
    results: dict[int, MapResult]
    program: Program
    achieved: Estimate
    sequential: dict[str, str]


@dataclass(frozen=True)
class Settled:
    """The outcome that is kept; `index` is its stage's place in the plan, `dropped` says why later
    stages are not used, by their places.
    """

    outcome: Outcome
    index: int
    dropped: dict[int, str]


Attempt = Callable[[Stage, bool], Outcome]
"""Maps a stage; the flag says that it is the kernel as written, the last resort."""


def settle(plan: Plan, attempt: Attempt) -> Settled:
    """Maps stages from the last one back until none before can be better.

    A stage whose hottest loop runs block by block for want of a mapping is better than none only.

    Raises
    ------
    VividcError
        What the attempt at the first stage, the kernel as written, raises.
    """
    best: Settled | None = None
    dropped: dict[int, str] = {}
    for index in reversed(range(len(plan.stages))):
        if best is not None and plan.stages[index].reserve:
            continue
        try:
            outcome = attempt(plan.stages[index], index == 0)
        except VividcError as error:
            if index == 0 and best is None:
                raise
            dropped[index] = f"taken back: {error.reason}"
            continue
        if best is None or _rank(outcome) < _rank(best.outcome):
            if best is not None:
                dropped[best.index] = "taken back: slower than without it once mapped"
            best = Settled(outcome, index, dropped)
        if index <= plan.asked:  # what the user asks for need not pay
            break
        if _rank(best.outcome) <= (False, _least(plan, index)):
            break
    assert best is not None
    return best


def _rank(outcome: Outcome) -> tuple[bool, float]:
    """Orders outcomes, the better first: with the hottest loop mapped, then by cycles.

    How long a loop takes block by block depends on trips that are only assumed, and it loses more
    the longer it runs.
    """
    return outcome.stage.estimate.hottest in outcome.sequential, outcome.achieved.cycles


def _least(plan: Plan, index: int) -> float:
    """Cycles that no stage before this one can go below."""
    before = (stage for stage in plan.stages[plan.asked : index] if not stage.reserve)
    return min(stage.estimate.least for stage in before)
