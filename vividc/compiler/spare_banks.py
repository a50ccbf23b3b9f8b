"""Loops mapped again at the IIs that they have, so that fewer accesses of one cycle meet in a bank.

The search for an II does not look at banks, and many schedules have the same II. What is expected
of arrays and pitches as the first mappings would place them tells the annealer which accesses
should be apart; arrays are placed anew for what comes of it.
"""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.compiler.delivery import residents
from vividc.compiler.planning.estimate import RegionCost
from vividc.dfg.regions import Kernel
from vividc.errors import InternalError
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, negotiate, prepare
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import Traffic, Words, words_of
from vividc.mapper.resources.plain_core import named_anew, unrotated
from vividc.program.encoder.banks import choose_layout

_PAYS: Final = 0.02
"""Of the cycles of all loops: stalls that are worth a search, and what has to come of it."""

_SEEDS: Final = range(1, 6)

_EFFORT: Final = Effort(moves=6000, rounds=30, repairs=60, trials=1)
"""Of each seed; each comes to other stalls."""

_ENOUGH: Final = 0.1
"""Of a loop's stalls: a mapping that leaves no more ends the search."""

_BUDGET_S: Final = 3.0
"""Seconds of effort, at most, for a kernel."""


@dataclass(frozen=True, slots=True)
class Runs:
    """How often each region is expected to be entered, and how many iterations that makes."""

    entries: Sequence[float]
    iterations: Sequence[float]

    @staticmethod
    def of(costs: Sequence[RegionCost]) -> Runs:
        """Those of an estimate."""
        return Runs([cost.runs for cost in costs], [cost.runs * cost.trips for cost in costs])


def with_fewer_stalls(
    kernel: Kernel,
    fabric: Fabric,
    results: ReadOnly[int, MapResult],
    runs: Runs,
    deadline: Deadline,
) -> dict[int, MapResult]:
    """The results of a kernel's loops, by region, those with many stalls mapped again at their IIs
    where that is expected to save cycles of a run.
    """
    better = dict(results)
    deadline = deadline.within(_BUDGET_S)
    loops = _Loops(kernel, fabric, runs)
    known = loops.known(better)
    before = {index: loops.cost(index, _mapping(better[index]), known) for index in better}
    least = _PAYS * sum(before.values())
    stalls = {index: loops.stalls(index, _mapping(better[index]), known) for index in better}
    for index in sorted(stalls, key=lambda index: -stalls[index]):
        if stalls[index] < least or deadline.passed:
            break
        mapping = loops.mapped_again(index, better, known, deadline)
        if mapping is None or loops.cost(index, mapping, known) > before[index] - least:
            continue
        better[index] = replace(better[index], mapping=mapping)
        known = loops.known(better)
    after = sum(loops.cost(index, _mapping(better[index]), known) for index in better)
    return better if after < sum(before.values()) else dict(results)


@dataclass(frozen=True, slots=True)
class _Loops:
    kernel: Kernel
    fabric: Fabric
    runs: Runs

    def traffic(self, index: int, mapping: Mapping) -> Traffic:
        """Of a mapped loop."""
        times = {node: place.time for node, place in mapping.places.items()}
        dfg, weight = self.kernel.regions[index].dfg, self.runs.iterations[index]
        return Traffic.of(dfg, self.fabric.scratchpad, mapping.ii, times, weight)

    def known(self, results: ReadOnly[int, MapResult]) -> Words:
        """Where arrays start and how far apart their rows lie, as is best for these mappings."""
        traffic = [self.traffic(index, _mapping(result)) for index, result in results.items()]
        pitches, starts = choose_layout(self.kernel, traffic)
        return words_of(starts, pitches)

    def stalls(self, index: int, mapping: Mapping, known: Words) -> float:
        """Expected cycles of a run in which the loop stands still."""
        return self.runs.iterations[index] * self.traffic(index, mapping).stalls(known)

    def cost(self, index: int, mapping: Mapping, known: Words) -> float:
        """Expected cycles of a run in the loop."""
        first = max((place.time for place in mapping.places.values()), default=0)
        filled = self.runs.entries[index] * first
        steady = self.runs.iterations[index] * mapping.ii
        return filled + steady + self.stalls(index, mapping, known)

    def mapped_again(
        self, index: int, results: ReadOnly[int, MapResult], known: Words, deadline: Deadline
    ) -> Mapping | None:
        """The least costly of some mappings of a loop at its II; None: there is none."""
        dfg, old = self.kernel.regions[index].dfg, _mapping(results[index])
        others = [
            (self.kernel.regions[other].dfg, _mapping(result))
            for other, result in results.items()
            if other != index
        ]
        problem = MapProblem(dfg, self.fabric, {}, residents(self.fabric, others))
        core = replace(problem, fabric=unrotated(self.fabric))
        meetings = self.traffic(index, old).meetings(known)
        prepare(lambda _: None)
        enough = self.cost(index, old, known) - (1.0 - _ENOUGH) * self.stalls(index, old, known)
        found: list[Mapping] = []
        for seed in _SEEDS:
            if deadline.passed or (found and self.cost(index, found[-1], known) <= enough):
                break
            made = negotiate(core, old.ii, seed, deadline, _EFFORT, meetings=meetings)
            named = None if made is None else named_anew(problem, made)
            if named is None:
                continue
            faults = violations(dfg, self.fabric, named, resident=problem.resident)
            if faults:
                raise InternalError(f"another mapping of {dfg.name}: {faults[0].message}")
            found.append(replace(named, subject=old.subject))
        return min(found, key=lambda made: self.cost(index, made, known), default=None)


def _mapping(result: MapResult) -> Mapping:
    if result.mapping is None:
        raise InternalError("a loop without a mapping was to be mapped again")
    return result.mapping
