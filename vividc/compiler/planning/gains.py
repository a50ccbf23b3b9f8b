"""What a transformation has to bring, how large it may make a loop, and which are sure to bring
less or to make a larger one.
"""

from __future__ import annotations

import math
from typing import Final

from vividc.compiler.planning.candidates import MOST_ITERATIONS, Candidate, Kind
from vividc.compiler.planning.estimate import Estimate, Estimator, RegionCost
from vividc.compiler.planning.plan import Stage
from vividc.ssa.analysis.constant_trips import constant_trips
from vividc.ssa.flow import find_loops

OPERATIONS_PER_PE: Final[dict[Kind, int]] = {
    "full unrolling": 24,
    "unrolling": 12,
    "masked unrolling": 12,
    "flattening": 24,
    "threads": 24,
    "interleaving": 24,
    "restructuring": 8,
    "versioning": 24,
    "partial results": 12,
}
"""A loop's graph may not have more. What lies side by side is mapped soon (367 operations of 8
modular inverses at their bound in 4 s), and code that is unrolled fully has no other form as good
(302 operations of morton64 in 2 s). Of the others several sizes are tried: smaller ones come near.
"""

GAIN_WITHOUT_LOOP: Final = 0.8
"""The same where full unrolling leaves no loop around, for code that runs once."""

GAIN: Final[dict[Kind, float]] = {
    "full unrolling": 0.97,
    "unrolling": 0.9,
    "masked unrolling": 0.98,
    "flattening": 0.95,
    "threads": 0.9,
    "interleaving": 0.9,
    "restructuring": 0.9,
    "versioning": 0.9,
    "partial results": 0.985,
}
"""A transformation must bring the cycles below this share: its overheads vary more with the sizes
than full unrolling's, which are known.
"""

LARGE, GAIN_OF_LARGE = 256, 0.9
"""The same with a loop of so many operations (339 of bilateral, at 0.949, map nothing in 19 s)."""

LITTLE: Final = 0.045
"""A nest that saves a smaller share of the kernel's cycles is left alone, whatever it gains of its
own (`GAIN`): other nests are not restructured yet, and may lose most of theirs. At 0.02 the sums
of deriche, which save 0.04, take the constant stores that its other loops need.
"""


def pays_inside(base: Stage, header: str, estimate: Estimate) -> bool:
    """Whether a restructured nest gains of its own cycles what a kernel has to gain."""
    saved = base.estimate.cycles - estimate.cycles
    least = (1.0 - GAIN["restructuring"]) * base.cycles_in(header)
    return saved >= max(least, LITTLE * base.estimate.cycles)


_UNROLLED: Final = frozenset({"unrolling", "masked unrolling"})
_SURE, _SURE_OF_ALL = 1.25, 2.5
"""An unrolled loop of so many times the operations that it may have is not made, and one around
another that is unrolled fully: of 97 loops of 234 kernels that were unrolled, one kept 0.57 times
as many operations as it had in all iterations, the others 0.62 and more; those that stayed loops
0.89 times and more.
"""

_KEPT: Final = 0.8
"""Of the cycles that all PEs need for each operation of a nest in each iteration of its inner loop,
what one loop takes at least: of 46 nests of NPBench one took 0.88, the others 1.2 and more.
"""

_IN_GROUPS: Final = frozenset({"masked unrolling", "partial results"})
"""Unrolling is not among them: what saves less than it has to is still advised (`advice`)."""
_OF_GROUP: Final = 0.85
"""Of the operations of a group's iterations, those that are left of them at least. Of 449 loops of
NPBench that were tried in groups, a third has no room for a gain that pays if so many are left, and
none of these paid; at 0.89 two of 191 that paid would have none.
"""

_COUNTERS: Final = 2
"""An II to which counters of iterations bind a loop, too: those of a group are counted together."""


def too_large(operations: int, limit: int) -> str:
    """Why a loop is not made."""
    return f"a loop would have {operations} operations, more than {limit}"


def in_vain(estimator: Estimator, base: Stage, candidate: Candidate, limit: int) -> str:
    """Why a candidate need not be made, by what its loop is now: it is sure to have more operations
    than the `limit`, or not to come to the share of all cycles that pays; else nothing.
    """
    fits = base.estimate.cycles < math.inf
    pays = (1.0 - GAIN[candidate.kind]) * base.estimate.cycles if fits else -math.inf
    if candidate.kind == "flattening":
        return _flattened_in_vain(estimator, base, candidate.header, pays)
    cost = base.estimate.loop(candidate.header)
    if cost is None:
        return ""
    large = _is_surely_larger(estimator, base, candidate, cost, limit)
    return large or _grouped_in_vain(estimator, candidate, cost, pays)


def _is_surely_larger(
    estimator: Estimator, base: Stage, candidate: Candidate, cost: RegionCost, limit: int
) -> str:
    """Of a loop that recurrences do not give a mapper room for."""
    if not estimator.largest_loop(Estimate(cost.cycles, (cost,))):
        return ""
    times, sure = (candidate.factor if candidate.kind in _UNROLLED else 0), _SURE
    if candidate.kind == "full unrolling" and _is_only_one_inside(base, candidate.header):
        function, loop = base.state.function, base.state.loop(candidate.header)
        trips = constant_trips(function, loop, MOST_ITERATIONS)
        times, sure = (0 if trips is None else trips.iterations), _SURE_OF_ALL
    operations = times * cost.shape.operations
    return too_large(operations, limit) if operations > sure * limit else ""


def _grouped_in_vain(
    estimator: Estimator, candidate: Candidate, cost: RegionCost, pays: float
) -> str:
    """Iterations that run together take what all PEs need for their operations, and what the
    recurrence needs that each of them goes on with, unless each has a result of its own.
    """
    if candidate.kind not in _IN_GROUPS:
        return ""
    factor, shape = candidate.factor, cost.shape
    least = math.ceil(_OF_GROUP * factor * shape.operations / len(estimator.fabric.pes))
    if shape.bound is not None and shape.bound.name == "RecMII":
        is_shared = candidate.kind == "partial results" or shape.ii <= _COUNTERS
        least = max(least, shape.ii if is_shared else factor * shape.ii)
    groups = (cost.trips + (factor - 1) / 2) / factor
    if cost.runs * (cost.trips * shape.ii - groups * least) >= pays:
        return ""
    return f"{factor} of its iterations would take {least} cycles, one takes {shape.ii}"


def _flattened_in_vain(estimator: Estimator, base: Stage, header: str, pays: float) -> str:
    """Each iteration executes what is around the inner loop, too."""
    inside = base.state.loop(header).blocks
    costs = [cost for cost in base.estimate.regions if cost.header in inside]
    loops = [cost for cost in costs if cost.kind == "loop"]
    if len(loops) != 1:
        return ""
    operations = sum(cost.shape.operations for cost in costs)
    iterations = loops[0].runs * loops[0].trips
    least = _KEPT * iterations * operations / len(estimator.fabric.pes)
    own = base.cycles_in(header, estimator.fabric.controller.switch_cycles)
    if own - least >= pays:
        return ""
    return f"one loop would have {operations} operations in each of {iterations:.0f} iterations"


def _is_only_one_inside(base: Stage, header: str) -> bool:
    """Whether the loop around this one is an innermost loop without it."""
    loops = [one for one in find_loops(base.state.function) if one.header != header]
    around = [one.blocks for one in loops if header in one.blocks]
    inmost = min(around, key=len, default=frozenset())
    return sum(one.header in inmost for one in loops) == 1
