"""Cycles that a function would take on a fabric, from bounds instead of mappings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal

from vividc.arch.fabric import Fabric
from vividc.dfg.alike import Graph, Optimized, numbered, with_addresses
from vividc.dfg.check import check
from vividc.dfg.cut.build import Cut, build_kernel
from vividc.dfg.ir import DFG
from vividc.dfg.pipeline import PassOptions, optimize, optimize_kernel, pipeline
from vividc.dfg.regions import Kernel, Region, least_trips, loop_behind, loops_before, runs_into
from vividc.errors import SourceLoc
from vividc.host import time_limit
from vividc.host.watch import is_watched
from vividc.machine.opcodes import OPCODES, Opcode
from vividc.mapper.bounds.bounds import all_bounds, mii, no_ii
from vividc.mapper.bounds.straight import straight_lower_bound
from vividc.mapper.mapping import Bound
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import Traffic
from vividc.mapper.resources.dependences import dependences, earliest_starts
from vividc.ssa.analysis.frequency import entries_of, expected_trips, frequencies, rare_blocks
from vividc.ssa.formats.pack_lanes import pack_lanes
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import normalize

_ROUTING = 1.3
"""An iteration's span over its longest path: words travel, and operations wait for PEs."""

_ROOMY = 0.65
"""Of a loop's slots: as many operations are mapped within seconds (adi: 437 with an II of 46,
seidel: 375 with an II of 38; adi's 540 are not).
"""
_ROOMY_REASSOCIATED = 0.7
_OF_REASSOCIATED = 12
"""The same where float sums have any order, which leaves short recurrences, of loops of so many
operations a PE: seidel's 168 with an II of 18 are mapped in 5 s.
"""

_NEVER = 1 << 20
"""Stands for the length of a region that no mapping exists for."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A region's time by itself: cycles between iterations, cycles of one, and what binds the II.

    `ii` of a straight region is its length, as is `span`. `stalls`: cycles of an iteration in which
    accesses are expected to meet in a bank. `entries`: of constant stores, that the accesses of a
    loop need at least. `drain`: of a mapped loop, cycles before its end in which the region behind
    it begins; None: not known yet. `fill`: of a mapped straight region, cycles before its end in
    which the loop behind it begins.
    """

    ii: int
    span: int
    operations: int
    bound: Bound | None = None
    stalls: float = 0.0
    entries: int = 0
    drain: int | None = None
    fill: int = 0

    @property
    def is_possible(self) -> bool:
        """Whether no bound rules out every mapping."""
        return self.ii < _NEVER


@dataclass(frozen=True, slots=True)
class RegionCost:
    """A region's share: `runs` times entered, with `trips` iterations each time. It ends `early`
    before its span is over, a loop at most `earliest`: the region behind it has begun, and nothing
    passes between the two. `is_rare`: its contexts are brought in the rare case of a run that needs
    them.
    """

    header: str
    kind: str
    shape: Shape
    runs: float
    trips: float
    loc: SourceLoc | None = None
    early: float = 0.0
    earliest: float = 0.0
    is_rare: bool = False

    @property
    def cycles(self) -> float:
        """Cycles over the whole run, region switches aside."""
        rest = max(self.trips - 1.0, 0.0) * self.shape.ii
        first = min(self.trips, 1.0) * (self.shape.span - self.early)
        return self.runs * (first + rest) + self.stalls

    @property
    def stalls(self) -> float:
        """Cycles of them in which accesses meet in a bank."""
        return self.runs * self.trips * self.shape.stalls

    @property
    def allowance(self) -> float:
        """The part of the cycles that an estimate sets aside for routing, and for what the region
        behind a loop has to wait for.
        """
        span = max(self.shape.ii, math.floor(self.shape.span / _ROUTING))
        spared = self.shape.span - span + self.earliest - self.early
        return self.runs * min(self.trips, 1.0) * spared


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cycles of one run of a function, and of its regions."""

    cycles: float
    regions: tuple[RegionCost, ...]

    @property
    def least(self) -> float:
        """Cycles that no mapping can save: no allowance for routing, no stalls."""
        loops = [cost for cost in self.regions if cost.kind == "loop"]
        stalls = sum(cost.stalls for cost in self.regions)
        return self.cycles - stalls - sum(cost.allowance for cost in loops)

    @property
    def contexts(self) -> int:
        """The fewest contexts that the regions take, but for rare ones."""
        return sum(cost.shape.ii for cost in self.regions if not cost.is_rare)

    @property
    def entries(self) -> int:
        """Of constant stores, that the accesses of loops need at least, where these share none."""
        return sum(cost.shape.entries for cost in self.regions)

    def largest_loop(self, pes: int, *, reassociated: bool = False) -> int:
        """Operations of the largest modulo-scheduled loop, those aside that half of the slots of so
        many PEs suffice for: recurrences give a mapper room.
        """
        loops = (r.shape for r in self.regions if r.kind == "loop")
        return max((s.operations for s in loops if not _is_roomy(s, pes, reassociated)), default=0)

    @property
    def largest_straight(self) -> int:
        """Operations of the largest straight region."""
        return max((r.shape.operations for r in self.regions if r.kind == "straight"), default=0)

    @property
    def hottest(self) -> str:
        """Header of the modulo-scheduled loop with most cycles; "" without one."""
        loops = [cost for cost in self.regions if cost.kind == "loop"]
        return max(loops, key=lambda cost: cost.cycles).header if loops else ""

    def loop(self, header: str) -> RegionCost | None:
        """The modulo-scheduled loop of this header."""
        return next((r for r in self.regions if r.header == header and r.kind == "loop"), None)


def _is_roomy(shape: Shape, pes: int, reassociated: bool) -> bool:
    """Whether recurrences give a mapper room in a loop."""
    few = reassociated and shape.operations <= _OF_REASSOCIATED * pes
    share = _ROOMY_REASSOCIATED if few else _ROOMY
    return shape.operations <= share * shape.ii * pes


@dataclass(frozen=True, slots=True)
class Room:
    """What is not estimated to its end, as it is not wanted: a loop with more operations that
    recurrences give no room for; else regions that take more contexts.
    """

    operations: int
    contexts: float


_EARLY: Final = 0.5
"""Of the cycles by which a region may begin early, those that it gains so: others wait for what the
loop is yet to give (PolyBench).
"""

Spaces = Literal["none", "paying", "all"]


@dataclass
class Estimator:
    """Estimates functions on one fabric; regions seen before cost nothing again."""

    fabric: Fabric
    options: PassOptions
    spaces: Spaces = "none"
    """Of which matrices rows may lie further apart than they are long: where it pays, or of all,
    wherever that is possible.
    """
    resident: bool = False
    """The configuration memory holds rare regions, too."""
    _prepared: dict[int, tuple[Function, Function]] = field(default_factory=dict)
    _built: dict[int, tuple[Function, Kernel]] = field(default_factory=dict)
    """Both by the identity of the function, which is kept so that nothing else gets it."""
    _last: tuple[Function, Cut] | None = None
    _optimized: dict[int, Optimized] = field(default_factory=dict)
    """By the identity of the graph."""
    _alike: dict[DFG, Optimized] = field(default_factory=dict)
    """By the graph with numbered variables."""
    _shapes: dict[tuple[str, DFG], Shape] = field(default_factory=dict)
    """Of optimised graphs with numbered variables, without stalls."""
    _stalls: dict[Graph, float] = field(default_factory=dict)
    _shape_of: dict[int, Shape] = field(default_factory=dict)
    """By the identity of a region's graph."""

    def estimate(
        self, function: Function, hints: Mapping[str, float], room: Room | None = None
    ) -> Estimate:
        """The estimate; infinite if a region cannot be mapped or the contexts do not suffice.

        Parameters
        ----------
        hints
            Iterations of loops by header, where the caller knows better, and how often a branch
            goes to a block.
        room
            Of what is beyond it as many regions are estimated as show that, and the estimate is
            infinite.
        """
        function = self.prepared(function, hints)
        beyond = self._beyond(function, hints, room) if room is not None else []
        if beyond:
            shapes = [self.shape(region) for region in beyond]
            return Estimate(math.inf, self._costs(function, beyond, shapes, hints))
        return self._estimate(function, hints)

    def prepared(self, function: Function, hints: Mapping[str, float]) -> Function:
        """The normalised function whose regions are built: with numbers of 16 and 8 bits in lanes
        if it is no slower so. A function has the same hints each time.
        """
        if id(function) not in self._prepared:
            self._prepared[id(function)] = function, self._prepare(function, hints)
        return self._prepared[id(function)][1]

    def _prepare(self, function: Function, hints: Mapping[str, float]) -> Function:
        plain = normalize(function)
        packed = pack_lanes(plain)
        if packed is plain:
            return plain
        packed = normalize(packed)
        is_slower = self._estimate(packed, hints).cycles > self._estimate(plain, hints).cycles
        return plain if is_slower else packed

    def _estimate(self, function: Function, hints: Mapping[str, float]) -> Estimate:
        kernel = self.built(function)
        shapes = [self.shape(region) for region in kernel.regions]
        return self.priced(function, kernel, shapes, hints)

    def priced(
        self,
        function: Function,
        kernel: Kernel,
        shapes: list[Shape],
        hints: Mapping[str, float],
        *,
        most: bool = False,
        brought: float | None = None,
    ) -> Estimate:
        """The cycles of a normalised function's regions if they have these shapes; `most`: if each
        begins as early under the end of the one before as it may; `brought`: in which contexts are
        brought, where they may be of more regions than rare ones.
        """
        costs = self._costs(function, kernel.regions, shapes, hints)
        costs = self._with_fills(self._with_drains(costs, kernel, most), kernel, most)
        switches = sum(cost.runs for cost in costs) * self.fabric.controller.switch_cycles
        total = sum(cost.cycles for cost in costs) + switches + (brought or 0.0)
        estimate = Estimate(total, costs)
        is_too_long = brought is None and estimate.contexts > self.fabric.controller.contexts
        return replace(estimate, cycles=math.inf) if is_too_long else estimate

    def _costs(
        self,
        function: Function,
        regions: Sequence[Region],
        shapes: Iterable[Shape],
        hints: Mapping[str, float],
    ) -> tuple[RegionCost, ...]:
        trips = expected_trips(function, hints)
        runs = frequencies(function, trips, hints)
        entries = entries_of(function, runs)
        rare: Set[str] = frozenset() if self.resident else rare_blocks(function, runs)

        def times(region: Region) -> tuple[float, float]:
            header, is_loop = region.header, region.kind == "loop"
            return (entries[header], trips[header]) if is_loop else (runs[header], 1.0)

        return tuple(
            RegionCost(r.header, r.kind, shape, *times(r), r.loc, is_rare=r.header in rare)
            for r, shape in zip(regions, shapes, strict=True)
        )

    def _rare(self, function: Function, hints: Mapping[str, float]) -> Set[str]:
        """Blocks whose contexts are brought in the rare case that they are needed."""
        if self.resident:
            return frozenset()
        trips = expected_trips(function, hints)
        return rare_blocks(function, frequencies(function, trips, hints))

    def _with_drains(
        self, costs: tuple[RegionCost, ...], kernel: Kernel, most: bool
    ) -> tuple[RegionCost, ...]:
        """Loops end as early as the regions behind them can begin, which saves the switch, too."""
        if not self.fabric.is_plain:
            return costs
        made, switch = list(costs), self.fabric.controller.switch_cycles
        for after, loop in loops_before(kernel.regions).items():
            shape, length = costs[loop].shape, costs[after].shape.ii
            if shape.drain is None:
                earliest = min(shape.span - max(shape.ii, switch), length)
                early = earliest * (1.0 if most else _EARLY)
            else:
                early = earliest = shape.drain
            if earliest > 0 and shape.is_possible:
                early, earliest = early + switch, earliest + switch
                made[loop] = replace(costs[loop], early=early, earliest=earliest)
        return tuple(made)

    def _with_fills(
        self, costs: tuple[RegionCost, ...], kernel: Kernel, most: bool
    ) -> tuple[RegionCost, ...]:
        """Loops begin before the regions before them have ended, if they have so many iterations
        that they end later, and that saves the switch, too.
        """
        made, runs = list(costs), [cost.runs for cost in costs]
        for index, cost in enumerate(costs):
            loop = loop_behind(kernel.regions, index) if cost.shape.fill or most else None
            if loop is None or not self.fabric.is_plain:
                continue
            behind, fill = costs[loop].shape, cost.shape.fill
            if most and not fill and behind.is_possible:
                fill = min(cost.shape.ii, behind.span)
            least = least_trips(fill, behind.ii, behind.span, behind.drain or 0)
            if costs[loop].trips >= least:
                share = runs_into(kernel.regions, index, loop, runs) / (cost.runs or 1.0)
                early = share * (fill + self.fabric.controller.switch_cycles)
                made[index] = replace(cost, early=early)
        return tuple(made)

    def iterations(
        self, function: Function, kernel: Kernel, hints: Mapping[str, float]
    ) -> tuple[float, ...]:
        """How many of each region of a normalised function a run is expected to have."""
        costs = self.expected(function, kernel, hints)
        return tuple(cost.runs * cost.trips for cost in costs)

    def expected(
        self, function: Function, kernel: Kernel, hints: Mapping[str, float]
    ) -> tuple[RegionCost, ...]:
        """How often each region of a normalised function is expected to run: of no shape yet."""
        shapes = [Shape(1, 1, 0)] * len(kernel.regions)
        return self.priced(function, kernel, shapes, hints).regions

    def contexts(self, function: Function, kernel: Kernel, hints: Mapping[str, float]) -> int:
        """The fewest contexts that a normalised function's regions take, but for rare ones; a loop
        that cannot be mapped as one counts nothing.
        """
        rare = self._rare(function, hints)
        every = (self.shape(region).ii for region in kernel.regions if region.header not in rare)
        return sum(ii for ii in every if ii < _NEVER)

    def shape(self, region: Region) -> Shape:
        """The region's shape by its bounds."""
        known = self._shape_of.get(id(region.dfg))
        if known is None:
            known = self._shaped(self.optimized(region.dfg), region.kind)
            self._shape_of[id(region.dfg)] = known  # `_optimized` keeps the graph
        return known

    def _shaped(self, dfg: DFG, kind: str) -> Shape:
        alike, graph = (kind, numbered(dfg)), with_addresses(dfg)
        problem = MapProblem(dfg, self.fabric)
        shape = self._shapes.get(alike)
        if shape is None:
            time_limit.step("regions were estimated")
            bounded = _loop_shape if kind == "loop" else _straight_shape
            shape = self._shapes[alike] = bounded(problem)
        stalls = self._stalls.get(graph)
        if stalls is None:
            stalls = self._stalls[graph] = _stalls(problem, shape.ii)
        return replace(shape, stalls=stalls)

    def optimized(self, dfg: DFG) -> DFG:
        """The region's graph after the passes, unchecked and nameless. A graph that differs in the
        names of its variables only is found again: of two stages of a plan, most regions do.
        """
        if id(dfg) not in self._optimized:
            alike = numbered(dfg)
            first = self._alike.get(alike)
            known = None if first is None else first.like(dfg)
            self._optimized[id(dfg)] = known or self._made(dfg)
            self._alike.setdefault(alike, self._optimized[id(dfg)])
        return self._optimized[id(dfg)].done

    @cached_property
    def entries(self) -> int:
        """Of the constant stores of PEs that access the scratchpad."""
        loads = OPCODES[Opcode.LOAD]
        return sum(pe.constants for pe in self.fabric.pes if pe.executes(loads))

    def largest_loop(self, estimate: Estimate) -> int:
        """Operations of the largest loop that recurrences do not give a mapper room for."""
        reassociated = self.options.reassociate
        return estimate.largest_loop(len(self.fabric.pes), reassociated=reassociated)

    def _made(self, dfg: DFG) -> Optimized:
        done = replace(dfg, name="")
        for step in pipeline(self.options):
            time_limit.step("regions were optimised")
            done = step(done)
        return Optimized(dfg, done, True)

    def _beyond(self, function: Function, hints: Mapping[str, float], room: Room) -> list[Region]:
        """As many regions of a prepared function as show that it is beyond the room; none if it is
        not.
        """
        found: list[Region] = []
        contexts, rare = 0, self._rare(function, hints)
        pes, reassociated = len(self.fabric.pes), self.options.reassociate
        for region in self._cut(function).loops_first():
            shape = self.shape(region)
            found.append(region)
            contexts += shape.ii if region.header not in rare else 0
            if region.kind == "loop":
                is_beyond = shape.operations > room.operations and not _is_roomy(
                    shape, pes, reassociated
                )
            else:
                is_beyond = contexts > room.contexts
            if is_beyond:
                return found
        return []

    def built(self, function: Function) -> Kernel:
        """The regions of a prepared function; whoever looks on sees how they are made."""
        if is_watched():
            return build_kernel(function)
        if id(function) not in self._built:
            self._built[id(function)] = function, self._cut(function).kernel()
        return self._built[id(function)][1]

    def _cut(self, function: Function) -> Cut:
        """The regions of a prepared function, of which some may be built; the last one's only."""
        if self._last is None or self._last[0] is not function:
            self._last = function, Cut(function)
        return self._last[1]

    def optimized_kernel(self, kernel: Kernel) -> Kernel:
        """As `optimize_kernel`; what was estimated is checked, but not optimised again."""
        if is_watched():
            return optimize_kernel(kernel, self.options)
        regions = (replace(region, dfg=self._checked(region.dfg)) for region in kernel.regions)
        return replace(kernel, regions=tuple(regions))

    def _checked(self, dfg: DFG) -> DFG:
        known = self._optimized.get(id(dfg))
        if known is None or not known.is_own or check(known.done):
            return optimize(dfg, self.options)  # one that is alike has other source lines
        return replace(known.done, name=dfg.name)


def _loop_shape(problem: MapProblem) -> Shape:
    bounds = all_bounds(problem)
    ii = mii(bounds)
    operations = len(problem.dfg.operations)
    if ii >= no_ii(problem):
        return Shape(_NEVER, _NEVER, operations, bounds[0])
    nodes = [node.id for node in problem.dfg.placed]
    starts = earliest_starts(nodes, dependences(problem.dfg, problem.fabric), ii) or {}
    ends = (start + problem.fabric.latency(problem.dfg.by_id[n]) for n, start in starts.items())
    span = math.ceil(max(ends, default=1) * _ROUTING)
    accesses = (node for node in problem.dfg.placed if node.is_memory)
    entries = {key for node in accesses for key in problem.constants_of(node)}
    bound = bounds[0] if bounds else None
    return Shape(ii, max(span, ii), operations, bound, entries=len(entries))


def _stalls(problem: MapProblem, ii: int) -> float:
    """Of an iteration whose accesses may start in any of its cycles."""
    return 0.0 if ii >= _NEVER else Traffic.of(problem.dfg, problem.fabric.scratchpad, ii).stalls()


def _straight_shape(problem: MapProblem) -> Shape:
    operations = len(problem.dfg.operations)
    if not problem.dfg.placed:
        return Shape(1, 1, operations)
    bound = straight_lower_bound(problem)
    return Shape(bound.ii, bound.ii, operations, bound)
