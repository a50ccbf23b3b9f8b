"""Maps the straight regions of a kernel around its loops, as they are mapped."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from collections.abc import Mapping as ReadOnly
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal

from vividc.arch.fabric import Fabric
from vividc.compiler.regions.delivery import deliver
from vividc.compiler.regions.earlier import Earlier, posed, straight_key
from vividc.compiler.regions.homes import variable_homes
from vividc.compiler.regions.map_again import Runs, layout_for
from vividc.compiler.regions.stores import Homes, Stores
from vividc.dfg.alike import unnamed
from vividc.dfg.ir import DFG
from vividc.dfg.regions import Kernel, Region, loops_before
from vividc.errors import InternalError, MappingFailed
from vividc.host import time_limit
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.bounds.straight import straight_lower_bound
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping, Status
from vividc.mapper.problem import Drain
from vividc.mapper.resources.banks import NOTHING, Meets, Traffic, Words
from vividc.mapper.resources.drain import drain_of
from vividc.mapper.result import mapping_of
from vividc.program.encoder.checks import span_of

Progress = Callable[[str], None]

IsLost = Callable[[ReadOnly[int, tuple[int, int]]], bool]
"""Whether a kernel is of no use whose regions have at least these IIs and spans, by index."""

Thrift = Literal["none", "frugal", "last"]
"""How entries in constant stores are spared for regions scheduled later: not, as `list_schedule`
does, or that in the last attempt.
"""

NODE_S = 0.003
"""Rough seconds that one trial of a straight region takes for each node."""

_PAYS = 1
"""Cycles that must be saved by beginning yet earlier, which takes contexts."""

Mapped = tuple[Kernel, dict[int, MapResult]]
"""A kernel whose regions hold their deliveries, and the result of each region by index."""


@dataclass(frozen=True, slots=True)
class Straight:
    """How straight regions are mapped: `earlier` keeps what is known, `runs` says how often regions
    are expected to run.
    """

    fabric: Fabric
    progress: Progress | None
    runs: Runs | None
    earlier: Earlier
    is_lost: IsLost

    def mapped(
        self, kernel: Kernel, results: ReadOnly[int, MapResult], thrift: Thrift
    ) -> Mapped | None:
        """With straight regions around the loops of these results; None: it is of no use.

        A region that can begins while the loop before it ends, which takes a few contexts more:
        none does if there are not as many.

        Raises
        ------
        MappingFailed
            There is no room for a straight region, which is crowded then, and hopeless in the last
            attempt.
        """
        made = self._all(kernel, results, thrift, loops_before(kernel.regions))
        if made is None:
            return None
        used = sum(mapping_of(result).ii for result in made[1].values())
        is_early = any(region.drain for region in made[0].regions)
        if is_early and used > self.fabric.controller.contexts:
            return self._all(kernel, results, thrift, {})
        return made

    def _all(
        self,
        kernel: Kernel,
        results: ReadOnly[int, MapResult],
        thrift: Thrift,
        before: ReadOnly[int, int],
    ) -> Mapped | None:
        """`before`: by straight region, a loop while which ends it may begin."""
        fabric, entries = self.fabric, None if self.runs is None else self.runs.entries
        done, regions = dict(results), list(kernel.regions)
        loops = {index: mapping_of(result) for index, result in results.items()}
        homes = variable_homes(kernel, fabric, loops, entries)
        known = NOTHING if self.runs is None else layout_for(kernel, fabric, results, self.runs)
        stores = Stores.of(kernel, fabric).with_homes(homes)
        stores = stores.with_regions((regions[index].dfg, loop) for index, loop in loops.items())
        straight = [(i, r) for i, r in enumerate(kernel.regions) if r.kind != "loop"]
        pace = _Pace(sum(len(region.dfg.placed) for _, region in straight))
        for index, region in straight:
            loop = before.get(index)
            drained = None if loop is None else (regions[loop], loops[loop])
            runs_once = entries is not None and loop is not None and entries[loop] <= 1.0
            place = _Place(self, pace, homes, known, thrift != "none", runs_once)
            try:
                ready, done[index], early, stores = place.found(index, region, stores, drained)
            except MappingFailed as error:
                if thrift == "last":
                    self.earlier.hopeless[unnamed(region.dfg)] = error
                self.earlier.crowded.add(unnamed(region.dfg))
                raise
            if loop is not None:
                regions[loop] = replace(regions[loop], drain=early)
            if self.is_lost(spans_of(kernel, fabric, done)):
                return None
            regions[index] = replace(region, dfg=ready)
        return replace(kernel, regions=tuple(regions)), done


@dataclass(frozen=True, slots=True)
class _Place:
    """How one straight region is mapped where variables live in `homes` and so much is `known` of
    addresses; `runs_once`: as of `_One`.
    """

    straight: Straight
    pace: _Pace
    homes: Homes
    known: Words
    frugal: bool
    runs_once: bool

    def found(
        self, index: int, region: Region, stores: Stores, drained: tuple[Region, Mapping] | None
    ) -> tuple[DFG, MapResult, int, Stores]:
        """The region's graph with its deliveries, its result, by how many cycles it begins before
        the loop `drained` has ended, and what constant stores hold with it.

        Raises
        ------
        MappingFailed
            There is no room for it.
        """
        fabric = self.straight.fabric
        for held in stores.beside(index):
            ready = deliver(region, self.homes, fabric, held)
            problem = MapProblem(ready.dfg, fabric, ready.allowed, held)
            meets = Traffic.of(ready.dfg, fabric.scratchpad, 1).meets(self.known)
            one = _One(self.straight, self.pace, meets, self.frugal, self.runs_once)
            self.pace.begin(len(problem.dfg.placed))
            made, early = one.found(problem, () if drained is None else _drains(*drained, problem))
            beside = stores.with_regions([(ready.dfg, mapping_of(made))])
            if beside.fit():
                return ready.dfg, made, early, beside
        text = f"the constant stores have no entries left for what {region.name} reads and writes"
        raise MappingFailed(text, loc=region.loc)


def spans_of(
    kernel: Kernel, fabric: Fabric, results: ReadOnly[int, MapResult]
) -> dict[int, tuple[int, int]]:
    """The II and the span of each mapped region."""
    found = ((index, mapping_of(result)) for index, result in results.items())
    return {i: (made.ii, span_of(kernel.regions[i], made, fabric)) for i, made in found}


def _drains(loop: Region, mapping: Mapping, problem: MapProblem) -> tuple[Drain, ...]:
    """What is left of a loop if the straight region behind it begins as early as it gains by: by as
    many cycles as its own are at least; or, as it may have to let accesses of the loop pass, by
    twice as many.
    """
    fabric = problem.fabric
    span = span_of(loop, mapping, fabric)
    most = span - max(mapping.ii, fabric.controller.switch_cycles)
    least = min(most, straight_lower_bound(problem).ii)
    if least <= 0 or not fabric.is_plain:
        return ()
    early = dict.fromkeys((least, min(most, 2 * least)))
    return tuple(drain_of(loop.dfg, fabric, mapping, span - cycles, cycles) for cycles in early)


@dataclass
class _Pace:
    """How fast straight regions are scheduled, to predict the time of the rest."""

    nodes: int
    done: int = 0
    spent_s: float = 0.0
    _of_this: int = 0
    _began: float = 0.0

    def begin(self, nodes: int) -> None:
        """A region of so many nodes is scheduled now."""
        self.nodes -= nodes
        self._of_this, self._began = nodes, time_limit.now()

    def leaves_time(self) -> bool:
        """Whether another trial of the region leaves time for one of each other."""
        if self._of_this:  # its first trial is over
            self.spent_s += time_limit.now() - self._began
            self.done += self._of_this
            self._of_this = 0
        node_s = max(self.spent_s / max(self.done, 1), NODE_S)
        if time_limit.remaining_s() > self.nodes * node_s:
            return True
        time_limit.left_out("the search for shorter schedules of straight regions")
        return False


@dataclass(frozen=True, slots=True)
class _One:
    """How one straight region is mapped; `runs_once`: the loop before it does, so that contexts are
    worth more than cycles.
    """

    straight: Straight
    pace: _Pace
    meets: Meets
    frugal: bool
    runs_once: bool

    def found(self, problem: MapProblem, lefts: Sequence[Drain]) -> tuple[MapResult, int]:
        """The result, and by how many cycles it begins early: by none if it takes less time so.

        Parameters
        ----------
        lefts
            What may be left of the loop before it then, the least first.
        """
        best, least, early = None, math.inf, 0
        switch = problem.fabric.controller.switch_cycles
        for left in lefts:
            if best is not None and (self.runs_once or least <= 0):
                break
            with suppress(MappingFailed):
                made = self._mapped(replace(problem, drain=left))
                after = mapping_of(made).ii - left.cycles
                if after < least - _PAYS * (best is not None):
                    best, least, early = made, after, left.cycles
        if best is not None:
            takes = mapping_of(best).ii if self.runs_once else least - switch + 1
            if takes <= straight_lower_bound(problem).ii:
                return best, early
        alone = self._mapped(problem)
        if best is None or takes > mapping_of(alone).ii:
            return alone, 0
        return best, early

    def _mapped(self, problem: MapProblem) -> MapResult:
        start = time.monotonic()
        mapping = self._scheduled(problem)
        faults = violations(
            problem.dfg,
            problem.fabric,
            mapping,
            allowed=problem.allowed,
            resident=problem.resident,
            straight=True,
        )
        if faults:
            raise InternalError(f"list schedule of {problem.dfg.name}: {faults[0].message}")
        bound = straight_lower_bound(problem)
        wall_s = time.monotonic() - start
        if self.straight.progress is not None:
            self.straight.progress(f"{problem.dfg.name}: {mapping.ii} cycles")
        status: Status = "optimal" if mapping.ii <= bound.ii else "feasible"
        return MapResult(status, mapping.ii, bound.ii, (bound,), mapping, "list", wall_s)

    def _scheduled(self, problem: MapProblem) -> Mapping:
        """The schedule, which is kept for another stage's."""
        known = self.straight.earlier.straight
        key = posed(problem), straight_key(self.meets, self.frugal)
        if key not in known:
            leaves_time = self.pace.leaves_time
            try:
                made = list_schedule(problem, leaves_time, frugal=self.frugal, meets=self.meets)
            except MappingFailed as error:
                known[key] = error
                raise
            known[key] = made
        found = known[key]
        if isinstance(found, MappingFailed):
            raise found
        return found
