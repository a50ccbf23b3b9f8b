"""Maps one straight region between the loops next to it: it may begin while the one before it ends,
and the one behind it may begin while it ends.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from vividc.compiler.regions.earlier import Earlier, posed, straight_key
from vividc.dfg.regions import Region
from vividc.errors import InternalError, MappingFailed
from vividc.host import time_limit
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.bounds.straight import straight_lower_bound
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping, Status
from vividc.mapper.problem import Drain
from vividc.mapper.resources.banks import Meets
from vividc.mapper.resources.drain import drain_of
from vividc.mapper.resources.fill import fill_of, first_begin
from vividc.mapper.result import mapping_of
from vividc.program.encoder.checks import span_of

Progress = Callable[[str], None]

NODE_S = 0.003
"""Rough seconds that one trial of a straight region takes for each node."""

_PAYS = 1
"""Cycles that must be saved by beginning yet earlier, which takes contexts."""

_SHARES = (0.25, 0.6)
"""Of the way from the cycle in which the loop behind could begin by bounds to the one in which it
can by the schedule: schedules are sought with which it begins there.
"""

_LARGEST = 400
"""Operations and live-outs of a region for which it is sought: of larger ones it takes long, and
their accesses leave the loop no cycle (symm, covariance, correlation, cholesky).
"""

_LONGER = 12
"""Contexts that a region may take more for it."""

_FAR = 256
"""Cycles of the loop behind, more than there are: what it needs comes before all else."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """The loops next to a straight region, as they are mapped.

    Attributes
    ----------
    before, behind
        None: there is none that may be under way at the same time.
    runs_once
        The one before it does, so that contexts are worth more than cycles.
    trips, share
        Iterations that the one behind is expected to have each time, and how often, of the times
        that the region is entered, that one follows.
    pays
        Cycles of an entry of the region that are worth a search.
    """

    before: tuple[Region, Mapping] | None = None
    behind: tuple[Region, Mapping] | None = None
    runs_once: bool = False
    trips: float = math.inf
    share: float = 1.0
    pays: float = 0.0


@dataclass(frozen=True, slots=True)
class Found:
    """How a straight region is mapped: it begins `early` so many cycles before the loop before it
    has ended, and the one behind it in its last `fill` cycles.
    """

    result: MapResult
    early: int
    fill: int = 0


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
class Pace:
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
class One:
    """How one straight region is mapped: `earlier` keeps what is known, `frugal` and `meets` are as
    of `list_schedule`.
    """

    earlier: Earlier
    progress: Progress | None
    pace: Pace
    meets: Meets
    frugal: bool
    around: Neighbours

    def found(self, problem: MapProblem) -> Found:
        """The region between its neighbours.

        Raises
        ------
        MappingFailed
            There is no room for it.
        """
        found = self._found(problem)
        _demand_right(problem, mapping_of(found.result))
        return found

    def _found(self, problem: MapProblem) -> Found:
        before, behind = self.around.before, self.around.behind
        drains = () if before is None else _drains(*before, problem)
        made, early = self._drained(problem, drains)
        if behind is None or not problem.fabric.is_plain:
            return Found(made, early)
        begun = [left for left in drains if left.cycles == early]
        if begun:
            problem = replace(problem, drain=begun[0])
        return self._filled(problem, Found(made, early), *behind)

    def _drained(self, problem: MapProblem, lefts: Sequence[Drain]) -> tuple[MapResult, int]:
        """The result, and by how many cycles it begins early: by none if it takes less time so.

        Parameters
        ----------
        lefts
            What may be left of the loop before it then, the least first.
        """
        best, least, early = None, math.inf, 0
        switch, runs_once = problem.fabric.controller.switch_cycles, self.around.runs_once
        for left in lefts:
            if best is not None and (runs_once or least <= 0):
                break
            with suppress(MappingFailed):
                made = self._mapped(replace(problem, drain=left))
                after = mapping_of(made).ii - left.cycles
                if after < least - _PAYS * (best is not None):
                    best, least, early = made, after, left.cycles
        if best is not None:
            takes = mapping_of(best).ii if runs_once else least - switch + 1
            if takes <= straight_lower_bound(problem).ii:
                return best, early
        alone = self._mapped(problem)
        if best is None or takes > mapping_of(alone).ii:
            return alone, 0
        return best, early

    def _filled(self, problem: MapProblem, found: Found, loop: Region, mapping: Mapping) -> Found:
        """The loop behind it begins as early as its schedule lets it, or that of another schedule,
        in which what the loop needs comes first.
        """
        fabric, length = problem.fabric, mapping_of(found.result).ii
        longest, switch = length + _LONGER, fabric.controller.switch_cycles
        most = self._most(problem, loop, mapping)
        first = fill_of(loop.dfg, fabric, mapping, longest)

        def begin_of(made: MapResult) -> int | None:
            found_at = mapping_of(made)
            return first_begin(first, problem, found_at, found_at.ii - most)

        def price(cycles: int, begin: int | None) -> float:
            """Cycles of the region until what follows begins."""
            end = cycles + switch
            return end if begin is None else end - self.around.share * (end - begin)

        begin = begin_of(found.result)
        best = found if begin is None else replace(found, fill=length - begin)
        least, paid = length + switch if begin is None else begin, price(length, begin)
        if len(problem.dfg.placed) > _LARGEST:
            return best
        alone = replace(problem, fill=replace(first, expected=_FAR))
        bound = max(straight_lower_bound(alone).ii - _FAR, length - most)
        for share in _SHARES if least - bound >= self.around.pays else ():
            target = bound + round(share * (least - bound))
            expected = length - target
            if target >= least or expected <= 0 or not self.pace.leaves_time():
                continue
            cycles = expected + _LONGER
            there = fill_of(loop.dfg, fabric, mapping, cycles, target, expected)
            with suppress(MappingFailed):
                made = self._mapped(replace(problem, fill=there))
                begin = begin_of(made)
                cycles = mapping_of(made).ii
                if begin is not None and price(cycles, begin) < paid and cycles <= longest:
                    least, paid = begin, price(cycles, begin)
                    best = Found(made, found.early, cycles - begin)
        return best

    def _most(self, problem: MapProblem, loop: Region, mapping: Mapping) -> int:
        """Cycles of the loop behind for which its live bits do, and with which it begins early if
        it has as many iterations as expected, however early it ends.
        """
        controller, before = problem.fabric.controller, self.around.before
        stages, ii = controller.max_stages, mapping.ii
        if before is not None:
            last_time = max((place.time for place in before[1].places.values()), default=0)
            stages -= last_time // before[1].ii + 2
        last = min(span_of(loop, mapping, problem.fabric), max(ii, controller.switch_cycles))
        further = max(0.0, self.around.trips - 1.0) * ii
        return max(0, math.floor(min((stages - 1) * ii, further + last)))

    def _mapped(self, problem: MapProblem) -> MapResult:
        start = time.monotonic()
        mapping = self._scheduled(problem)
        bound = straight_lower_bound(replace(problem, fill=None))
        wall_s = time.monotonic() - start
        if self.progress is not None:
            self.progress(f"{problem.dfg.name}: {mapping.ii} cycles")
        status: Status = "optimal" if mapping.ii <= bound.ii else "feasible"
        return MapResult(status, mapping.ii, bound.ii, (bound,), mapping, "list", wall_s)

    def _scheduled(self, problem: MapProblem) -> Mapping:
        """The schedule, which is kept for another stage's."""
        known = self.earlier.straight
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


def _demand_right(problem: MapProblem, mapping: Mapping) -> None:
    """Raises InternalError if the verifier finds anything wrong with a schedule."""
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
