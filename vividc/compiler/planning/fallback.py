"""Chooses the stage of a plan to keep: the most transformed one that maps, unless an earlier one
turns out faster.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from vividc.compiler.planning.estimate import Estimate, Estimator
from vividc.compiler.planning.plan import Plan, Stage
from vividc.dfg.regions import Kernel
from vividc.errors import KernelError, MappingFailed, TimeLimit, VividcError
from vividc.mapper.deadline import Deadline
from vividc.mapper.result import MapResult
from vividc.program import Program
from vividc.ssa.ir import Function

_AS_WRITTEN = 0.4
"""The kernel as written is sure of this share, if it has to be mapped: a plan is never worse."""

_STAGE_S = 25.0
"""A stage of transformed loops is given up after so long, and an earlier one mapped instead."""

TRANSFORMED_GUARD = 0.75
"""Of the time that is left, after which the clock ends a stage of transformed loops. What it may
spend is effort, and the clock only guards it: with the same share of both, a machine half as fast
as the typical one came to other words (march_scene at seven times the cycles).
"""

_LONGER = "give a longer --time-limit: smaller forms of its loops were not mapped in time"

HASTY = 1.05
"""Of the cycles that the best stage is expected to take, or has come to: a stage that is expected
to take so many is left out in haste. Of 8 kernels with such a stage two gain by it, 1 and 3 %.
"""

_HOPEFUL = 0.9
"""Of the cycles achieved: what is in reserve is mapped, too, if it is expected to take so few."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Effort for all stages together, and the part of it that transformed ones may use."""

    whole: Deadline
    transformed: Deadline

    @staticmethod
    def of(whole: Deadline) -> Budget:
        """The budget of mapping that starts now."""
        return Budget(whole, whole.within(whole.remaining_s * (1.0 - _AS_WRITTEN)))

    def share(self, as_written: bool) -> Deadline:
        """When mapping the next stage must end.

        Raises
        ------
        TimeLimit
            What is left is kept for the kernel as written.
        """
        if as_written:
            return self.whole
        if self.transformed.passed:
            raise TimeLimit("no time was left for it", hint="give a longer --time-limit")
        limit_s = min(self.whole.remaining_s / 2, _STAGE_S, self.transformed.remaining_s)
        return self.whole.within(limit_s)


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


@dataclass(frozen=True)
class Race:
    """A stage that is of use only if it takes less than `below` cycles, as others are counted.

    Attributes
    ----------
    function, hints
        Of the stage, as its regions are built.
    """

    estimator: Estimator
    function: Function
    hints: Mapping[str, float]
    below: float

    def is_lost(self, kernel: Kernel, known: Mapping[int, tuple[int, int]]) -> bool:
        """Whether it is sure to take that long.

        Parameters
        ----------
        known
            The least II and span of regions, by index; straight ones have bounds otherwise.
        """
        if self.below == math.inf:
            return False
        built = self.estimator.built(self.function)
        shapes = [replace(self.estimator.shape(region), stalls=0.0) for region in built.regions]
        for index, (ii, span) in known.items():
            shapes[index] = replace(shapes[index], ii=ii, span=span)
        priced = self.estimator.priced(self.function, kernel, shapes, self.hints, most=True)
        cycles = priced.cycles
        return self.below <= cycles < math.inf


Attempt = Callable[[Stage, bool, float], Outcome | None]
"""Maps a stage; the flag says that it is the kernel as written, the last resort. None: it is sure
to take as many cycles as the number says, or more.
"""


def settle(plan: Plan, attempt: Attempt, most: float = math.inf) -> Settled:
    """Maps stages from the last one back until none before can be better, or is expected to take
    less than `most` times the cycles of the best one.

    A stage whose hottest loop runs block by block for want of a mapping is better than none only.

    Raises
    ------
    VividcError
        What the attempt at the first stage, the kernel as written, raises.
    """
    best: Settled | None = None
    dropped: dict[int, str] = {}
    is_late = False
    for index in reversed(range(len(plan.stages))):
        if best is not None and not _is_worth_it(plan.stages[index], best, most):
            continue
        try:
            outcome = attempt(plan.stages[index], index == 0, _below(best))
        except VividcError as error:
            if index == 0 and best is None:
                if is_late and isinstance(error, KernelError | MappingFailed):
                    raise type(error)(error.reason, loc=error.loc, hint=_LONGER) from error
                raise
            is_late = is_late or isinstance(error, TimeLimit)
            dropped[index] = f"taken back: {error.reason}"
            continue
        if outcome and (best is None or _rank(outcome) < _rank(best.outcome)):
            if best is not None:
                dropped[best.index] = "taken back: slower than without it once mapped"
            best = Settled(outcome, index, dropped)
        assert best is not None
        if index <= plan.asked:  # what the user asks for need not pay
            break
        if _rank(best.outcome) <= (False, _least(plan, index, best, most)):
            break
    assert best is not None
    return best


def _is_worth_it(stage: Stage, best: Settled, most: float) -> bool:
    """Whether it is expected to take less than `most` times the cycles of the best one, if that has
    its hottest loop mapped. What is in reserve is mapped, too, where the better stage by estimate
    came out much slower than the one in reserve is expected to be.
    """
    expected, achieved = stage.estimate.cycles, best.outcome.achieved.cycles
    if stage.reserve:
        return expected < _HOPEFUL * achieved
    if _rank(best.outcome)[0]:
        return True
    return expected < most * max(achieved, best.outcome.stage.estimate.cycles)


def _below(best: Settled | None) -> float:
    """Cycles that a stage must take less of to be better; infinite: any may be."""
    if best is None or _rank(best.outcome)[0]:
        return math.inf
    return best.outcome.achieved.cycles


def _rank(outcome: Outcome) -> tuple[bool, float]:
    """Orders outcomes, the better first: with the hottest loop mapped, then by cycles.

    How long a loop takes block by block depends on trips that are only assumed, and it loses more
    the longer it runs.
    """
    return outcome.stage.estimate.hottest in outcome.sequential, outcome.achieved.cycles


def _least(plan: Plan, index: int, best: Settled, most: float) -> float:
    """Cycles that no stage before this one that is worth it can go below."""
    before = (stage for stage in plan.stages[plan.asked : index] if _is_worth_it(stage, best, most))
    return min((stage.estimate.least for stage in before), default=math.inf)
