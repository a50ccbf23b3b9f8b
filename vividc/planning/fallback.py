"""From a plan to the stage that is kept: the most transformed one that maps, unless an earlier one
turns out faster.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vividc.dfg.regions import Kernel
from vividc.errors import VividcError
from vividc.mapper.mapping import MapResult
from vividc.planning.choose import Plan, Stage
from vividc.planning.estimate import Estimate
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
"""Maps a stage; the flag says that it is the last resort."""


def settle(plan: Plan, attempt: Attempt) -> Settled:
    """Maps stages from the last one back until one is at least as good as the one before can be.

    Raises
    ------
    VividcError
        What the attempt at the first stage, the kernel as written, raises.
    """
    best: Settled | None = None
    dropped: dict[int, str] = {}
    for index in reversed(range(len(plan.stages))):
        try:
            outcome = attempt(plan.stages[index], index == 0)
        except VividcError as error:
            if index == 0 and best is None:
                raise
            dropped[index] = f"taken back: {error.reason}"
            continue
        if best is None or outcome.achieved.cycles < best.outcome.achieved.cycles:
            if best is not None:
                dropped[best.index] = "taken back: slower than without it once mapped"
            best = Settled(outcome, index, dropped)
        if index <= plan.asked:  # what the user asks for need not pay
            break
        if best.outcome.achieved.cycles <= plan.stages[index - 1].estimate.cycles:
            break
    assert best is not None
    return best
