"""A plan: the stages of a kernel from as written to most transformed, and what was decided."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Hashable, Iterator
from dataclasses import dataclass, field, replace

from vividc.compiler.planning.candidates import Candidate, Kind, apply
from vividc.compiler.planning.estimate import Estimate, Estimator
from vividc.compiler.planning.nests.parts import static_part, with_tree
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.state import State
from vividc.errors import SourceLoc
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.loops.left_out import without_loops
from vividc.ssa.polyhedral.orders.search import describe
from vividc.ssa.polyhedral.trees import Loop as Nest
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy


@dataclass(frozen=True, slots=True)
class Decision:
    """One transformation that was tried.

    Attributes
    ----------
    header, origin
        The loop, and the loop of the source that it comes from.
    before, after
        Estimated cycles of one run of the kernel; `after` is None if it was refused.
    reason
        Why it was refused or does not pay; else empty.
    """

    kind: Kind
    header: str
    origin: str
    factor: int
    loc: SourceLoc | None
    before: float
    after: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Stage:
    """A function to map, its estimate, and the decision that made it of the stage `base`.

    `reserve`: the next stage is better by estimate; this one takes fewer contexts, or little more,
    and is for when that cannot be mapped or comes out much slower.
    """

    state: State
    estimate: Estimate
    decision: Decision | None = None
    base: Stage | None = None
    reserve: bool = False

    def lineage(self) -> Iterator[Stage]:
        """The stage, the one that it was made of, and so on to the first."""
        yield self
        if self.base is not None:
            yield from self.base.lineage()

    def cycles_in(self, header: str, switch: int = 0) -> float:
        """Estimated cycles in a nest; `switch`: what it takes to enter a region."""
        inside = self.state.loop(header).blocks
        own = (cost for cost in self.estimate.regions if cost.header in inside)
        return sum(cost.cycles + cost.runs * switch for cost in own)


@dataclass(frozen=True)
class Plan:
    """Stages from the kernel as it was to the most transformed one, and what was decided.

    `asked` is the last stage that the user asks for. If nests are restructured, stages without that
    are among those before it, or behind it where they are the better ones.
    """

    stages: tuple[Stage, ...]
    decisions: tuple[Decision, ...] = ()
    asked: int = 0


_MOSTLY = 0.6
"""Of a kernel's blocks: if loops beside a nest have so many, the nest is estimated alone first."""

_NEARLY, _ABOUT = 1.02, {"flattening": 1.05}
"""What a kernel takes by what one nest alone gains is so many times what it is estimated to take,
at most: of 274 candidates of three programs of NPBench 1.039 times for flattening (which saves
regions between nests, too), 1.014 for others.
"""


@dataclass
class Draft:
    """A plan in the making.

    Attributes
    ----------
    stages, decisions
        So far.
    parallel
        Lines of the function's file in which a loop over `prange` begins.
    fixed
        Headers of loops of which the user has decided.
    now
        The stage to go on from.
    spare
        Another one, of fewer contexts.
    """

    estimator: Estimator
    options: LoopOptions
    stages: list[Stage]
    parallel: frozenset[int] = frozenset()
    decisions: list[Decision] = field(default_factory=list)
    fixed: set[str] = field(default_factory=set)
    spare: Stage | None = None
    _made: dict[tuple[Hashable, ...], tuple[State, State | Refusal]] = field(default_factory=dict)
    """By the identity of the state that something was made of, which is kept so that no other one
    gets it, and what was made: several ways to a plan begin alike.
    """
    _alone: dict[tuple[int, str], tuple[Stage, Stage | None]] = field(default_factory=dict)
    """By the identity of a stage, which is kept, and the header of a loop."""

    def start(self, state: State) -> None:
        """`state` is what transformations begin with; it is no stage of its own."""
        self.now = Stage(state, self.estimator.estimate(state.function, state.hints))

    def accept(self, stage: Stage) -> None:
        """Goes on from a stage."""
        self.now = stage
        self.stages.append(stage)

    def applied(self, state: State, candidate: Candidate) -> State | Refusal:
        """The state after a candidate: the same one each time, of which the estimate is known."""

        def make() -> State | Refusal:
            return apply(state, candidate, expected_trips(state.function, state.hints))

        return self._once(state, (candidate,), make)

    def foreseen(
        self, base: Stage, candidate: Candidate, share: float, limit: int
    ) -> Estimate | None:
        """What a kernel of several nests takes after a candidate for one of them that does not pay
        for sure, by what this one alone would gain: about, in a fraction of the time that the whole
        kernel takes. None if it is to be estimated as a whole.

        Parameters
        ----------
        share
            Of the cycles, that pays.
        limit
            Operations that a loop may have.
        """
        alone = self._nest_alone(base, candidate.header)
        state = None if alone is None else self.applied(alone.state, candidate)
        if alone is None or not isinstance(state, State):
            return None
        estimate = self.estimator.estimate(state.function, state.hints)
        contexts = base.estimate.contexts - alone.estimate.contexts + estimate.contexts
        fits = contexts <= self.estimator.fabric.controller.contexts
        cycles = base.estimate.cycles - alone.estimate.cycles + estimate.cycles
        least = _ABOUT.get(candidate.kind, _NEARLY) * share * base.estimate.cycles
        is_in_vain = fits and least < cycles < math.inf
        is_small = self.estimator.largest_loop(estimate) <= limit
        return replace(estimate, cycles=cycles) if is_in_vain and is_small else None

    def _nest_alone(self, base: Stage, header: str) -> Stage | None:
        """A stage without the loops beside one; None if most of it would be left."""
        key = (id(base), header)
        if key not in self._alone:
            self._alone[key] = base, self._made_alone(base, header)
        return self._alone[key][1]

    def _made_alone(self, base: Stage, header: str) -> Stage | None:
        function = base.state.function
        own = base.state.loop(header).blocks
        beside = [
            loop.header
            for loop in reversed(find_loops(function))
            if header not in loop.blocks and loop.header not in own
        ]
        rest, taken = without_loops(function, beside)
        if len(taken) < _MOSTLY * len(function.blocks):
            return None
        state = replace(base.state, function=tidy(rest))
        return Stage(state, self.estimator.estimate(state.function, state.hints))

    def with_nest(self, state: State, header: str, order: int, nest: Nest) -> State | Refusal:
        """As `with_tree`, the same state each time."""

        def make() -> State | Refusal:
            trips = expected_trips(state.function, state.hints)
            return with_tree(state, header, order, nest, trips)

        return self._once(state, (header, order, describe(nest)), make)

    def _once(
        self, state: State, what: tuple[Hashable, ...], make: Callable[[], State | Refusal]
    ) -> State | Refusal:
        key = (id(state), *what)
        if key not in self._made:
            self._made[key] = state, make()
        return self._made[key][1]

    def note(
        self, base: Stage, candidate: Candidate, estimate: Estimate | None, reason: str
    ) -> Decision:
        """Keeps what was decided of a candidate."""
        header = candidate.header
        decision = Decision(
            candidate.kind,
            header,
            base.state.origin.get(header, header),
            candidate.factor,
            base.state.loc(header),
            base.estimate.cycles,
            None if estimate is None or math.isinf(estimate.cycles) else estimate.cycles,
            reason,
        )
        self.decisions.append(decision)
        return decision

    def around_one_loop(self, stage: Stage, tried: Collection[str]) -> list[str]:
        """Headers of loops that hold exactly one loop, inner ones first, without those in `tried`
        and those of which the user has decided.
        """
        loops, left = find_loops(stage.state.function), {*self.fixed, *tried}
        return [
            loop.header
            for loop in loops
            if sum(other.header in loop.blocks for other in loops if other is not loop) == 1
            and loop.header not in left
            and not self._is_left_alone(stage, loop.header)
        ]

    def _is_left_alone(self, stage: Stage, header: str) -> bool:
        """Whether the user wants the nest at `header` not to be flattened."""
        loc = stage.state.loc(header)
        return loc is not None and self.options.flatten.get(loc.line) is False

    def outermost(self) -> list[str]:
        """Headers of loops in no other one, with nothing in them that the user decided."""
        return [
            loop.header
            for loop in _outermost(self.now.state)
            if not any(header in loop.blocks for header in self.fixed | self.now.state.made)
        ]

    def nests(self) -> list[str]:
        """Headers of outermost loops, and of the outermost static-control parts in those that are
        none, such as loops that end when little has changed.
        """
        state, headers = self.now.state, self.outermost()
        opened = [state.loop(h).blocks for h in headers if _is_refused(state, h)]
        held = set[str]()
        for loop in reversed(find_loops(state.function)):  # outer ones first
            is_inside = any(loop.header in blocks for blocks in opened)
            if is_inside and loop.header not in held and not _is_refused(state, loop.header):
                held |= loop.blocks
                headers.append(loop.header)
        return headers

    def innermost(self) -> Iterator[Loop]:
        """Loops with no other one in them, of which the user decided nothing."""
        loops = find_loops(self.now.state.function)
        for loop in loops:
            holds = any(o.header in loop.blocks and o.header != loop.header for o in loops)
            if not holds and loop.header not in self.fixed:
                yield loop

    def open_loop(self, tried: Collection[str]) -> Loop | None:
        """A loop that was not tried, of which the user decided nothing."""
        for loop in find_loops(self.now.state.function):
            if loop.header not in tried and loop.header not in self.fixed:
                return loop
        return None

    def over_prange(self) -> list[str]:
        """Headers of the loops over `prange` that are in no other one."""
        state = self.now.state
        chosen: list[Loop] = []
        for loop in reversed(find_loops(state.function)):
            loc = state.loc(loop.header)
            marked = loc is not None and loc.file == state.function.file
            if loc is None or not marked or loc.line not in self.parallel:
                continue
            if loop.header not in self.fixed and not any(loop.header in o.blocks for o in chosen):
                chosen.append(loop)
        return [loop.header for loop in chosen]


def _is_refused(state: State, header: str) -> bool:
    return isinstance(static_part(state, header), Refusal)


def _outermost(state: State) -> list[Loop]:
    """Loops in no other one."""
    loops = find_loops(state.function)
    return [one for one in loops if not any(one.header in o.blocks - {o.header} for o in loops)]


_CLEARLY = 0.85
"""For interleaved iterations of a nest, times the cycles of the restructured one: jacobi-2d, where
16 iterations each are assumed, has 1.07 and takes 1.28 times its cycles.
"""


def clearly_better(stages: list[Stage], restructured: Stage) -> list[Stage]:
    """Without those of interleaved iterations, unless these are better by more than lengths that
    are not known may change: they load each element again that restructured ones share.
    """
    if stages and stages[-1].estimate.cycles < _CLEARLY * restructured.estimate.cycles:
        return stages
    return [stage for stage in stages if not any(map(_is_interleaving, stage.lineage()))]


def _is_interleaving(stage: Stage) -> bool:
    return stage.decision is not None and stage.decision.kind == "interleaving"


def better_last(ways: list[list[Stage]]) -> list[Stage]:
    """The stages of all ways, those with fewer cycles behind others; what is in reserve for the
    next one of its way comes before that.
    """
    keyed: list[tuple[float, Stage]] = []
    for way in ways:
        for stage, after in itertools.zip_longest(way, way[1:]):
            cycles = stage.estimate.cycles
            if stage.reserve and after is not None:
                cycles = max(cycles, after.estimate.cycles)
            keyed.append((cycles, stage))
    return [stage for _, stage in sorted(keyed, key=lambda one: -one[0])]
