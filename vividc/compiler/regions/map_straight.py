"""Maps the straight regions of a kernel around its loops, as they are mapped."""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, replace
from typing import Final, Literal

from vividc.arch.fabric import Fabric
from vividc.compiler.regions.delivery import deliver
from vividc.compiler.regions.earlier import Earlier
from vividc.compiler.regions.homes import variable_homes
from vividc.compiler.regions.map_again import Runs, layout_for
from vividc.compiler.regions.one_straight import Found, Neighbours, One, Pace, Progress
from vividc.compiler.regions.stores import Homes, Stores
from vividc.dfg.alike import unnamed
from vividc.dfg.ir import DFG
from vividc.dfg.regions import Kernel, Region, loop_behind, loops_before, runs_into
from vividc.errors import MappingFailed
from vividc.mapper import MapProblem, MapResult
from vividc.mapper.mapping import Mapping
from vividc.mapper.resources.banks import NOTHING, Traffic, Words
from vividc.mapper.result import mapping_of
from vividc.program.encoder.checks import span_of
from vividc.program.encoder.places import Turns

IsLost = Callable[[ReadOnly[int, tuple[int, int]]], bool]
"""Whether a kernel is of no use whose regions have at least these IIs and spans, by index."""

Thrift = Literal["none", "frugal", "last"]
"""How entries in constant stores are spared for regions scheduled later: not, as `list_schedule`
does, or that in the last attempt.
"""

_FILL_PAYS = 0.005
"""Of the cycles of all loops: what a loop that begins earlier must save to be worth a search."""

NO_REGIONS: Final[frozenset[int]] = frozenset()

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

        A region that can begins while the loop before it ends, and lets the one behind it begin
        while it ends, which takes a few contexts more: if there are not as many, loops begin no
        earlier, nor does any region if there still are not. Where rare regions alone are too many,
        or nothing helps, those regions overlap that stay in the configuration memory.

        Raises
        ------
        MappingFailed
            There is no room for a straight region, which is crowded then, and hopeless in the last
            attempt.
        """
        every, turns = frozenset(range(len(kernel.regions))), self._turns()
        before, most = loops_before(kernel.regions), self.fabric.controller.contexts
        first, made = None, None
        for loops, fills in ((before, every), (before, NO_REGIONS), ({}, NO_REGIONS)):
            made = self._all(kernel, results, thrift, loops, fills)
            if made is None:
                return None
            lengths = lengths_of(made)
            if not _is_early(made[0]) or sum(lengths) <= most:
                break
            first = first or made
            if turns is not None and turns.held(lengths) <= most:
                break
        if turns is None or first is None or sum(lengths) <= most:
            return made
        stays = turns.layout(lengths_of(first), self.fabric).stays
        loops = {after: loop for after, loop in before.items() if {after, loop} <= stays}
        fills = frozenset(i for i in stays if loop_behind(kernel.regions, i) in stays)
        apart = self._all(kernel, results, thrift, loops, fills)
        if apart is None or _stay(apart[0], turns.layout(lengths_of(apart), self.fabric).stays):
            return apart
        return self._all(kernel, results, thrift, {}, NO_REGIONS)

    def _turns(self) -> Turns | None:
        return None if self.runs is None else self.runs.turns

    def _all(
        self,
        kernel: Kernel,
        results: ReadOnly[int, MapResult],
        thrift: Thrift,
        before: ReadOnly[int, int],
        fills: Set[int],
    ) -> Mapped | None:
        """`before`: by straight region, a loop while which ends it may begin; `fills`: regions
        while which end loops may begin.
        """
        fabric, entries = self.fabric, None if self.runs is None else self.runs.entries
        loops = {index: mapping_of(result) for index, result in results.items()}
        done, regions = dict(results), list(kernel.regions)
        homes = variable_homes(kernel, fabric, loops, entries)
        known = NOTHING if self.runs is None else layout_for(kernel, fabric, results, self.runs)
        stores = Stores.of(kernel, fabric).with_homes(homes)
        stores = stores.with_regions((regions[index].dfg, loop) for index, loop in loops.items())
        straight = [(i, r) for i, r in enumerate(kernel.regions) if r.kind != "loop"]
        pace = Pace(sum(len(region.dfg.placed) for _, region in straight))
        for index, region in straight:
            around = self._around(kernel, index, loops, before, fills)
            place = _Place(self, pace, homes, known, thrift != "none", around)
            try:
                ready, found, stores = place.found(index, region, stores)
            except MappingFailed as error:
                if thrift == "last":
                    self.earlier.hopeless[unnamed(region.dfg)] = error
                self.earlier.crowded.add(unnamed(region.dfg))
                raise
            done[index], loop = found.result, before.get(index)
            if loop is not None:
                regions[loop] = replace(regions[loop], drain=found.early)
            if self.is_lost(spans_of(kernel, fabric, done)):
                return None
            regions[index] = replace(region, dfg=ready, fill=found.fill)
        return replace(kernel, regions=tuple(regions)), done

    def _around(
        self,
        kernel: Kernel,
        index: int,
        loops: ReadOnly[int, Mapping],
        before: ReadOnly[int, int],
        fills: Set[int],
    ) -> Neighbours:
        """The loops next to a straight region that may be under way meanwhile."""
        drained = before.get(index)
        filled = loop_behind(kernel.regions, index) if index in fills else None

        def mapped(loop: int | None) -> tuple[Region, Mapping] | None:
            return None if loop is None else (kernel.regions[loop], loops[loop])

        if self.runs is None:
            return Neighbours(mapped(drained), mapped(filled))
        entries, iterations = self.runs.entries, self.runs.iterations
        trips = math.inf if filled is None else iterations[filled] / max(entries[filled], 1.0)
        every = sum(iterations[loop] * made.ii for loop, made in loops.items())
        share = 1.0
        if filled is not None and entries[index] > 0:
            share = runs_into(kernel.regions, index, filled, entries) / entries[index]
        return Neighbours(
            mapped(drained),
            mapped(filled),
            drained is not None and entries[drained] <= 1.0,
            trips,
            share,
            _FILL_PAYS * every / max(entries[index], 1.0),
        )


@dataclass(frozen=True, slots=True)
class _Place:
    """How one straight region is mapped where variables live in `homes` and so much is `known` of
    addresses.
    """

    straight: Straight
    pace: Pace
    homes: Homes
    known: Words
    frugal: bool
    around: Neighbours

    def found(self, index: int, region: Region, stores: Stores) -> tuple[DFG, Found, Stores]:
        """The region's graph with its deliveries, how it is mapped, and what constant stores hold
        with it.

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
            straight = self.straight
            one = One(
                straight.earlier, straight.progress, self.pace, meets, self.frugal, self.around
            )
            self.pace.begin(len(problem.dfg.placed))
            found = one.found(problem)
            beside = stores.with_regions([(ready.dfg, mapping_of(found.result))])
            if beside.fit():
                return ready.dfg, found, beside
        text = f"the constant stores have no entries left for what {region.name} reads and writes"
        raise MappingFailed(text, loc=region.loc)


def lengths_of(made: Mapped) -> list[int]:
    """Contexts of each region; one that places nothing takes one."""
    kernel, results = made
    found = (results.get(index) for index in range(len(kernel.regions)))
    return [1 if result is None else mapping_of(result).ii for result in found]


def _is_early(kernel: Kernel) -> bool:
    return any(region.drain or region.fill for region in kernel.regions)


def _stay(kernel: Kernel, stays: Set[int]) -> bool:
    """Whether regions that overlap are among those."""
    for index, region in enumerate(kernel.regions):
        behind = loop_behind(kernel.regions, index) if region.fill else None
        others = {behind} if region.fill else {region.next} if region.drain else set()
        if others and not {index, *others} <= stays:
            return False
    return True


def spans_of(
    kernel: Kernel, fabric: Fabric, results: ReadOnly[int, MapResult]
) -> dict[int, tuple[int, int]]:
    """The II and the span of each mapped region."""
    found = ((index, mapping_of(result)) for index, result in results.items())
    return {i: (made.ii, span_of(kernel.regions[i], made, fabric)) for i, made in found}
