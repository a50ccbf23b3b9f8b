"""Loops mapped again at the IIs that they have, so that fewer accesses of one cycle meet in a bank
and iterations take fewer cycles.

The search for an II does not look at banks, nor at how long an iteration takes, and many schedules
have the same II. What is expected of arrays and pitches as the first mappings would place them
tells the annealer which accesses should be apart; arrays are placed anew for what comes of it. A
loop that is entered often is filled and drained as often: its schedules are made shorter as long as
that works.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal, TypeVar

from vividc.arch.fabric import Fabric
from vividc.compiler.planning.estimate import RegionCost
from vividc.compiler.regions.earlier import posed
from vividc.compiler.regions.stores import Stores
from vividc.dfg.regions import Kernel
from vividc.errors import InternalError
from vividc.mapper import EffortLevel, MapProblem, MapResult
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import (
    Effort,
    Frame,
    Try,
    annealing_s,
    least_span,
    loose_frame,
    negotiate_each,
    tight_frame,
)
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import NO_MEETINGS, Meetings, Traffic, Words, words_of
from vividc.mapper.resources.plain_core import named_anew, unrotated
from vividc.mapper.result import mapping_of
from vividc.program.encoder.banks import TRIES, choose_layout
from vividc.program.encoder.checks import span_of
from vividc.program.encoder.places import Turns

_Item = TypeVar("_Item")

_PAYS: Final = 0.02
_SAVES: Final = 0.002
"""Of the cycles of all loops: stalls that are worth a search, and what has to come of it."""

_SEEDS: Final = range(1, 9)

_EFFORT: Final = Effort(rounds=30, repairs=60, trials=1)
"""Of each seed; each comes to other stalls."""

_WEIGHT: Final = 10.0
_LIGHTER: Final = 3.0
"""How much more than the annealer's cost of a stall one costs in the first search, and by what that
is divided after each one that maps nothing, down to 1: of eight seeds of a loop of 168 operations
(hash encoding) all come to 0.6 to 1.6 stalls an iteration at 1, to 0 to 0.9 at 10; of one whose II
leaves few slots free (splats of a block) only one seed maps at all at 10, and most do at 3.
"""

_SHORTER_PAYS: Final = 0.01
"""Of the cycles of all loops: what iterations as short as their longest path would save that is
worth a search.
"""

_SHORTER_EFFORT: Final = Effort(moves=4000, rounds=30, repairs=60, trials=1)
"""Of each seed at a length; lengths are halved between the least one and the shortest found."""

_SHORTER_MISSES: Final = 2
"""Seeds at a length that map nothing, after which it is given up: of 54 lengths of PolyBench and
`kernels/` at which two failed, the third mapped two.
"""

_ENOUGH: Final = 0.1
"""Of a loop's stalls: a mapping that leaves no more ends the search; one that saves no more brought
nothing.
"""

_IDLE: Final = 2
_IDLE_S: Final = 0.6
"""Seeds in turn that bring nothing, those that map nothing at a larger weight than 1 not counted,
after which no more are tried, and the effort in seconds that their annealing may take if they are
more: of 15 large loops of PolyBench and `kernels/` no later one saved anything. Loops of 37 and 49
operations (mvt, covariance) save 3 % of all cycles by their last ones, and each takes 0.1 s.
"""


@dataclass(frozen=True, slots=True)
class Haste:
    """How long loops are mapped again.

    Attributes
    ----------
    most_s, worth_s
        Seconds of effort for a kernel's stalls, and for its iterations: at most, and for a share of
        its loops' cycles that they might be fewer by, times that share.
    moves
        Of each seed for fewer stalls, by operation: more seeds of fewer come to the same.
    is_frugal
        Annealing ends where what is broken is frozen, and every other seed alters the best mapping
        so far, which takes a third of the moves.
    """

    most_s: float
    worth_s: float
    moves: int
    is_frugal: bool

    def worth(self, share: float) -> float:
        """Seconds of effort for a share of the loops' cycles."""
        return self.worth_s * share if share > 0.0 else 0.0


_LONG: Final = Haste(most_s=5.0, worth_s=math.inf, moves=6000, is_frugal=False)
_HASTES: Final[dict[str, Haste]] = {
    "normal": Haste(most_s=2.5, worth_s=10.0, moves=4000, is_frugal=True),
    "thorough": _LONG,
    "prove": _LONG,
}
"""By effort; "fast" does not map again."""

_Way = Literal["anew", "stay", "open"]
"""How arrays lie while loops are mapped again: anew for each mapping, where they are, or as suits
loops whose accesses can start in any cycle.
"""


@dataclass(frozen=True, slots=True)
class Runs:
    """How often each region is expected to be entered, and how many iterations that makes; `turns`:
    how they come by turns, where contexts may be brought while the program runs.
    """

    entries: Sequence[float]
    iterations: Sequence[float]
    turns: Turns | None = None

    @staticmethod
    def of(costs: Sequence[RegionCost], turns: Turns | None = None) -> Runs:
        """Those of an estimate."""
        iterations = [cost.runs * cost.trips for cost in costs]
        return Runs([cost.runs for cost in costs], iterations, turns)


def with_fewer_cycles(
    kernel: Kernel,
    fabric: Fabric,
    results: ReadOnly[int, MapResult],
    runs: Runs,
    deadline: Deadline,
    effort: EffortLevel,
    tried: dict[Hashable, Mapping | None],
) -> dict[int, MapResult]:
    """The results of a kernel's loops, by region, those with many stalls or long iterations mapped
    again at their IIs where that is expected to save cycles of a run; `tried`: see `_Loops`.
    """
    haste = _HASTES.get(effort)
    if haste is None:
        return dict(results)
    until = deadline.within(haste.most_s)
    loops = _Loops(kernel, fabric, runs, haste=haste, deadline=until, tried=tried)
    apart = _with_fewer_stalls(loops, results)
    until = deadline.within(haste.most_s)
    return _with_shorter_iterations(replace(loops, deadline=until), apart)


def layout_for(
    kernel: Kernel, fabric: Fabric, results: ReadOnly[int, MapResult], runs: Runs
) -> Words:
    """Where arrays would start and how far apart their rows would lie for mapped loops alone."""
    return _Costs(kernel, fabric, runs).known(results, TRIES)


def _with_fewer_stalls(loops: _Loops, results: ReadOnly[int, MapResult]) -> dict[int, MapResult]:
    """Loops with many stalls mapped again, in up to three ways, the next one if stalls are left:
    arrays lie as suits loops whose accesses can start in any cycle, where no loop has to stall
    (fdtd-2d); or they are placed anew for every mapping, as one that stalls where they are may be
    the best where they could be (lu: 1.09 stalls an iteration or none); or they stay while a loop's
    mappings are compared, which does not give up a place that the other loops fit.
    """
    best = tried = dict(results)
    known = loops.known(tried)
    first = least = loops.total(tried, known)
    ways: tuple[_Way, ...] = ("open", "anew", "stay")
    if not first:
        return best
    until = loops.deadline.within(loops.haste.worth(loops.stalled(tried, known) / first))
    for way in ways:
        if loops.stalled(tried, known) < _PAYS * first or until.passed:
            break
        tried = _settled(loops, results, until, way, first)
        known = loops.known(tried)
        cycles = loops.total(tried, known)
        if cycles < least:
            best, least = tried, cycles
    return best


def _settled(
    loops: _Loops,
    results: ReadOnly[int, MapResult],
    until: Deadline,
    way: _Way,
    every: float,
) -> dict[int, MapResult]:
    """Each loop with many stalls mapped again, the worst first, where it saves cycles; `way`: how
    arrays lie, see above; `every`: the cycles of all loops before.
    """
    better = dict(results)
    known = loops.known_if_open(better) if way == "open" else loops.known(better)
    before = loops.total(better, known)
    stalls = {index: loops.stalls(index, mapping_of(better[index]), known) for index in better}
    for index in sorted(stalls, key=lambda index: -stalls[index]):
        if stalls[index] < _PAYS * every or until.passed:
            break
        share = until.within(loops.haste.worth(stalls[index] / every))
        made = loops.mapped_again(index, better, known, share, way == "anew")
        if made is None or made.cycles > before - _SAVES * every:
            continue
        better[index] = replace(better[index], mapping=made.mapping)
        if way != "open":
            known = loops.known(better)
        before = loops.total(better, known)
    return better


def _with_shorter_iterations(
    loops: _Loops, results: ReadOnly[int, MapResult]
) -> dict[int, MapResult]:
    better = dict(results)
    known = loops.known(better)
    every = sum(loops.cost(index, mapping_of(better[index]), known) for index in better)
    saved = {index: loops.spared(index, mapping_of(better[index])) for index in better}
    for index in sorted(saved, key=lambda index: -saved[index]):
        if saved[index] < _SHORTER_PAYS * every or loops.deadline.passed:
            break
        share = loops.deadline.within(loops.haste.worth(saved[index] / every))
        shorter = loops.mapped_shorter(index, better, known, share)
        better[index] = replace(better[index], mapping=shorter)
    return better


@dataclass(frozen=True, slots=True)
class _Try:
    """A mapping that is looked for: its iterations not longer than `span`, made of `start` if there
    is one.
    """

    seed: int
    meetings: Meetings
    span: int | None = None
    start: Mapping | None = None

    @property
    def key(self) -> Hashable:
        """What it is known by, of one loop and II."""
        start = self.start
        begun = start and tuple((node, at.pe, at.time) for node, at in sorted(start.places.items()))
        expected = self.meetings.accesses, self.meetings.stalls.tobytes()
        return self.seed, expected, self.span, begun

    def frame(self, core: MapProblem, ii: int) -> Frame | None:
        """Between which cycles operations are; None: there are no such cycles."""
        if self.span is None:
            frame = loose_frame(core, ii, self.meetings)
        else:
            frame = tight_frame(core, ii, self.span, self.meetings)
        return frame and replace(frame, origin=self.start)


@dataclass(frozen=True, slots=True)
class _Again:
    """Another mapping of a loop, and the cycles of all loops with it."""

    mapping: Mapping
    cycles: float


@dataclass(frozen=True)
class _Costs:
    """What mapped loops are expected to take."""

    kernel: Kernel
    fabric: Fabric
    runs: Runs
    _traffic: dict[tuple[int, int], tuple[Mapping, Traffic]] = field(default_factory=dict)
    """By region and the identity of its mapping, which is kept so that no other one gets it."""

    def traffic(self, index: int, mapping: Mapping) -> Traffic:
        """Of a mapped loop, which keeps what was found of it."""
        key = index, id(mapping)
        if key not in self._traffic:
            self._traffic[key] = mapping, self._traffic_of(index, mapping)
        return self._traffic[key][1]

    def _traffic_of(self, index: int, mapping: Mapping) -> Traffic:
        times = {node: place.time for node, place in mapping.places.items()}
        dfg, weight = self.kernel.regions[index].dfg, self.runs.iterations[index]
        return Traffic.of(dfg, self.fabric.scratchpad, mapping.ii, times, weight)

    def known(self, results: ReadOnly[int, MapResult], tries: int = 1) -> Words:
        """Where arrays start and how far apart their rows lie, as is best for these mappings;
        of many it is asked for, and so it is sought but once.
        """
        traffic = [self.traffic(index, mapping_of(result)) for index, result in results.items()]
        pitches, starts = choose_layout(self.kernel, traffic, tries)
        return words_of(starts, pitches)

    def known_if_open(self, results: ReadOnly[int, MapResult]) -> Words:
        """As is best for loops of these IIs whose accesses can start in any cycle, of stages
        that are drawn: with those of their mappings PolyBench takes 1.02 times as long.
        """
        traffic = [
            replace(self.traffic(index, mapping_of(result)), times=None, spread=True)
            for index, result in results.items()
        ]
        pitches, starts = choose_layout(self.kernel, traffic)
        return words_of(starts, pitches)

    def stalls(self, index: int, mapping: Mapping, known: Words) -> float:
        """Expected cycles of a run in which the loop stands still."""
        return self.runs.iterations[index] * self.traffic(index, mapping).stalls(known)

    def stalled(self, results: ReadOnly[int, MapResult], known: Words) -> float:
        """The same of all loops."""
        return sum(self.stalls(i, mapping_of(result), known) for i, result in results.items())

    def cost(self, index: int, mapping: Mapping, known: Words) -> float:
        """Expected cycles of a run in the loop."""
        filled = self.runs.entries[index] * self.span(index, mapping)
        steady = self.runs.iterations[index] * mapping.ii
        return filled + steady + self.stalls(index, mapping, known)

    def total(self, results: ReadOnly[int, MapResult], known: Words) -> float:
        """Expected cycles of a run in all loops."""
        return sum(self.cost(index, mapping_of(result), known) for index, result in results.items())

    def span(self, index: int, mapping: Mapping) -> int:
        """Cycles of an iteration."""
        return span_of(self.kernel.regions[index], mapping, self.fabric)

    def spared(self, index: int, mapping: Mapping) -> float:
        """Cycles of a run that iterations as short as their longest path would save."""
        problem = MapProblem(self.kernel.regions[index].dfg, self.fabric)
        least = least_span(problem, mapping.ii)
        return self.runs.entries[index] * max(0, self.span(index, mapping) - least)


@dataclass(frozen=True)
class _Loops(_Costs):
    """Loops that are mapped again.

    Attributes
    ----------
    haste
        How long they may be.
    deadline
        When negotiations must end; methods are told after which effort to begin none.
    tried
        What came of each negotiation; the ways of `_with_fewer_stalls` begin alike, and so do
        stages with equal loops.
    """

    haste: Haste = field(kw_only=True)
    deadline: Deadline = field(kw_only=True)
    tried: dict[Hashable, Mapping | None] = field(kw_only=True)

    @cached_property
    def empty(self) -> Stores:
        """What constant stores hold before a loop is mapped."""
        return Stores.of(self.kernel, self.fabric)

    def mapped_shorter(
        self, index: int, results: ReadOnly[int, MapResult], known: Words, until: Deadline
    ) -> Mapping:
        """A mapping of a loop at its II with shorter iterations, and no more stalls, which are only
        expected; the one it has where none is found.
        """
        best = mapping_of(results[index])
        problem = self.problem(index, results)
        least = least_span(problem, best.ii)
        stalls = self.stalls(index, best, known)
        apart = self.traffic(index, best).meetings(known)
        effort = replace(_SHORTER_EFFORT, quits=self.haste.is_frugal)
        turns = self.in_turns(((1, apart), (1, NO_MEETINGS), (2, NO_MEETINGS)))
        while (span := self.span(index, best)) > least and not self._is_over(
            problem, effort, until
        ):
            tried, better, misses = (least + span) // 2, None, 0
            for turn in turns:
                if misses >= _SHORTER_MISSES:
                    break
                tries = [_Try(seed, meetings, tried) for seed, meetings in turn]
                made = self._negotiated(problem, best, effort, tries)
                misses += made.count(None)
                good = (one for one in made if one and self.stalls(index, one, known) <= stalls)
                better = next(good, None)
                if better:
                    break
            best, least = (better, least) if better else (best, tried + 1)
        return best

    def in_turns(self, tries: Sequence[_Item]) -> list[Sequence[_Item]]:
        """Tries one after the other, or two at a time, where nothing tells how fast they come to an
        end: cores are idle otherwise.
        """
        each = 2 if self.haste.is_frugal else 1
        return [tries[first : first + each] for first in range(0, len(tries), each)]

    def problem(self, index: int, results: ReadOnly[int, MapResult]) -> MapProblem:
        """A loop beside the others as they are mapped, whose entries it leaves to them."""
        others = [
            (self.kernel.regions[other].dfg, mapping_of(result))
            for other, result in results.items()
            if other != index
        ]
        dfg = self.kernel.regions[index].dfg
        *_, held = self.empty.with_regions(others).beside(index)
        return MapProblem(dfg, self.fabric, {}, held)

    def mapped_again(
        self,
        index: int,
        results: ReadOnly[int, MapResult],
        known: Words,
        until: Deadline,
        anew: bool,
    ) -> _Again | None:
        """The least costly of some mappings of a loop at its II; None: there is none."""
        old, problem = mapping_of(results[index]), self.problem(index, results)
        meetings, weight = self.traffic(index, old).meetings(known), _WEIGHT
        stalls, least = self.stalls(index, old, known), self.total(results, known)
        enough = least - (1.0 - _ENOUGH) * stalls
        best: _Again | None = None
        altered = old
        effort = replace(_EFFORT, moves=self.haste.moves, quits=self.haste.is_frugal)
        most, idle = max(_IDLE, int(_IDLE_S / annealing_s(problem, effort))), 0
        for seeds in self.in_turns(_SEEDS):
            if least <= enough or idle >= most or self._is_over(problem, effort, until):
                break
            start = altered if self.haste.is_frugal else None
            apart = meetings.weighted(weight)
            tries = [_Try(seed, apart, start=None if seed % 2 else start) for seed in seeds]
            found = self._negotiated(problem, old, effort, tries)
            if weight > 1.0 and None in found:
                weight = max(1.0, weight / _LIGHTER)
                found = [made for made in found if made is not None]
            for made in found:
                idle += 1
                if made is None:
                    continue
                changed = {**results, index: replace(results[index], mapping=made)}
                cycles = self.total(changed, self.known(changed) if anew else known)
                if cycles < least - _ENOUGH * stalls:
                    idle = 0
                if best is None or cycles < best.cycles:
                    best = _Again(made, cycles)
                if cycles < least:
                    least, altered = cycles, made
        return best

    def _is_over(self, problem: MapProblem, effort: Effort, until: Deadline) -> bool:
        """Whether no effort is left; in haste, less than half of what a mapping takes."""
        least_s = annealing_s(problem, effort) / 2 if self.haste.is_frugal else 0.0
        return until.passed or until.remaining_s < least_s

    def _negotiated(
        self, problem: MapProblem, old: Mapping, effort: Effort, tries: Sequence[_Try]
    ) -> list[Mapping | None]:
        """Other mappings at the II of the `old` one, where there are some."""
        keys = [(posed(problem), old.ii, effort, one.key) for one in tries]
        new = [number for number, key in enumerate(keys) if key not in self.tried]
        made = self._newly_negotiated(problem, old.ii, effort, [tries[number] for number in new])
        found = {key: self.tried[key] for key in keys if key in self.tried}
        found |= {keys[number]: mapping for number, mapping in zip(new, made, strict=True)}
        late = self.deadline.passed
        self.tried.update({key: one for key, one in found.items() if one or not late})
        return [one and replace(one, subject=old.subject) for one in map(found.__getitem__, keys)]

    def _newly_negotiated(
        self, problem: MapProblem, ii: int, effort: Effort, tries: Sequence[_Try]
    ) -> list[Mapping | None]:
        core = replace(problem, fabric=unrotated(self.fabric))
        asked = [Try(core, ii, one.seed, effort, one.frame(core, ii)) for one in tries]
        made = negotiate_each(asked, self.deadline, len(asked)) if asked else []
        named = [mapping and named_anew(problem, mapping) for mapping in made]
        for mapping in named:
            if mapping is None:
                continue
            faults = violations(problem.dfg, self.fabric, mapping, resident=problem.resident)
            if faults:
                raise InternalError(f"another mapping of {problem.dfg.name}: {faults[0].message}")
        return named
