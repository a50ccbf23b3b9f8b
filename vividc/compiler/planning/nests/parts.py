"""Static-control parts of a function, estimated alone, and with other loops for one of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace

from vividc.compiler.planning.estimate import Estimate, Estimator, RegionCost, Room
from vividc.compiler.planning.state import MOST_INSTRUCTIONS, State
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.join import between, join
from vividc.ssa.loops.left_out import without_loops
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import Loops, expected_trips, iterations_of, loops_of
from vividc.ssa.polyhedral.orders.realigned import realigned
from vividc.ssa.polyhedral.orders.search import describe, has_masks, is_legal
from vividc.ssa.polyhedral.orders.sunk import sunk
from vividc.ssa.polyhedral.relations import Relations, Rows
from vividc.ssa.polyhedral.rows import rows_of
from vividc.ssa.polyhedral.schedule import schedule_of
from vividc.ssa.polyhedral.scop import Scop, find_scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

_PLANE = 2
"""Loops and subscripts of nests that are joined: they go through a matrix once."""

_MOST_JOINED = 16
"""Loops in no other one of a kernel whose nests are joined, those of a version for other sizes
among them (mvt has eight). Of deriche's, which takes 8 % fewer cycles so, two pairs are joined in a
quarter of its planning.
"""

_MOST_REALIGNED = 1
"""Orders with a sum's loop outermost that are compared with those of the source."""


_AS_FAST, _FEWER = 1.005, 0.7
"""Estimates nearer to each other say nothing: stencil7 has forms of 30 and of 69 contexts so."""

_SURE = 0.2
"""By this share all contexts must make it faster that groups which are not full follow behind the
others: at lengths that leave larger rests it is slower (covariance of 28 columns by 5: 8,252 cycles
instead of 6,176, where 96 contexts more make it faster by 2 % at the lengths that are expected).
"""

_SPARE = 0.25
"""Of the contexts: straight regions take more than their bounds (lu 545, where the bounds fit into
512), and may need more registers than there are (covariance).
"""

_STRAIGHT = (40, 60)
"""Operations of a straight region, times the PEs, that are sure and likely to be mapped: larger
ones may need more registers than there are (939 for 25 divisions at the end of a tile of
covariance), or more constants than the stores of PEs hold (16 rows of a layer norm, whose divisions
and roots have 1,779; 8 rows are mapped).
"""

_HOPE = 0.6
"""Of the cycles by which regions may begin earlier than is estimated."""

_BETTER = 0.99
"""A form is worth mapping, too, if it takes so much less with these: that of seidel-2d takes 0.84
times the cycles of the best one by estimate, that of jacobi-1d 1.39 times.
"""


@dataclass(frozen=True)
class Restructured:
    """A state with other loops, what is estimated of it, and the tree of these loops.

    `cycles`: the mean of what is estimated of it for symbols as they are expected, and larger; what
    is best for one is not for the other. `order`: which of the part's
    `written_orders` the tree is of. `carries`: registers carry elements from one iteration to the
    next. `other`: of the best form, one that is better if regions begin as early as they may.
    """

    state: State
    estimate: Estimate
    order: int
    tree: Loop
    factor: int
    cycles: float
    carries: bool
    other: Restructured | None = None

    @property
    def hopeful(self) -> float:
        """Its cycles if regions begin nearly as early as they may."""
        spared = (
            one.runs * min(one.trips, 1.0) * (one.earliest - one.early)
            for one in self.estimate.regions
        )
        return self.cycles - _HOPE * sum(spared)


def ranked(
    made: list[Restructured], estimator: Estimator, every: list[Restructured]
) -> tuple[Restructured, ...]:
    """The tree with the fewest estimated cycles, before it those that are likelier to be mapped;
    `every`: trees of other orders, too.
    """
    made = sorted(made, key=lambda one: one.cycles)
    if made:
        sure = surest(made, estimator)
        made.sort(key=lambda one: one is not sure)
    kept = dict.fromkeys((*(_most_likely(made, most, estimator) for most in _STRAIGHT), 0))
    forms = [_as_a_whole(made[place], estimator) for place in kept if made]
    other = min(every, key=lambda one: one.hopeful, default=None) if made else None
    if other is not None and other.hopeful < _BETTER * made[0].hopeful:
        forms[-1] = replace(forms[-1], other=_as_a_whole(other, estimator))
    return tuple(forms)


def _as_a_whole(one: Restructured, estimator: Estimator) -> Restructured:
    """With what is estimated of all nests together."""
    return replace(one, estimate=estimator.estimate(one.state.function, one.state.hints))


def surest(made: list[Restructured], estimator: Estimator) -> Restructured:
    """The fastest of these; or of it masked or not, and of those as fast that take far fewer
    contexts, one that takes fewer.
    """
    contexts = estimator.fabric.controller.contexts
    fastest = min(made, key=lambda one: one.cycles)
    shape, few = describe(fastest.tree).replace("?", ""), _FEWER * fastest.estimate.contexts

    def is_as_good(one: Restructured) -> bool:
        is_as_fast = one.cycles < _AS_FAST * fastest.cycles and one.estimate.contexts < few
        return is_as_fast or describe(one.tree).replace("?", "") == shape

    weighed = _SURE / contexts
    return min(
        filter(is_as_good, made), key=lambda one: one.cycles * (1 + weighed * one.estimate.contexts)
    )


def _most_likely(made: list[Restructured], straight: int, estimator: Estimator) -> int:
    """The place of the best of these whose contexts and straight regions (operations a PE) give a
    mapper room; 0 if none's do.
    """
    fabric = estimator.fabric
    room = (1.0 - _SPARE) * fabric.controller.contexts
    longest = straight * len(fabric.pes)
    for place, one in enumerate(made):
        if one.estimate.contexts <= room and one.estimate.largest_straight <= longest:
            return place
    return 0


@dataclass(frozen=True)
class Apart:
    """Estimates one nest in several forms, each without the other nests of the function: these take
    as long beside each form, and building their regions anew would take most of the time.

    Attributes
    ----------
    headers
        Of the loops in no other one that are left out.
    others
        What the regions take that are left out.
    """

    estimator: Estimator
    headers: frozenset[str]
    others: tuple[RegionCost, ...]
    _rests: dict[int, tuple[Function, Function]] = field(default_factory=dict, compare=False)
    """By the identity of the form, with the form: the same rest of it each time."""

    @staticmethod
    def of(
        estimator: Estimator,
        function: Function,
        hints: Mapping[str, float],
        inside: Collection[str],
    ) -> Apart:
        """For nests with loops of the headers `inside`."""
        loops = find_loops(function)
        outer = [
            loop
            for loop in loops
            if not any(loop.header in o.blocks and o.header != loop.header for o in loops)
        ]
        headers = frozenset(o.header for o in outer if o.blocks.isdisjoint(inside))
        _, taken = without_loops(function, headers)
        costs = estimator.estimate(function, hints).regions if taken else ()
        return Apart(estimator, headers, tuple(cost for cost in costs if cost.header in taken))

    def estimate(
        self, function: Function, *hints: Mapping[str, float], room: Room | None = None
    ) -> tuple[Estimate, ...]:
        """As the estimator does of a form, for each of several hints."""
        rest = self._rest(function)
        if room is not None:
            room = replace(room, contexts=room.contexts - self.contexts)
        return tuple(self._with_others(self.estimator.estimate(rest, one, room)) for one in hints)

    @property
    def contexts(self) -> int:
        """The fewest that the other nests take."""
        return sum(cost.shape.ii for cost in self.others if not cost.is_rare)

    def entries(self, estimate: Estimate) -> int:
        """Of constant stores, as of an estimate, that accesses of this nest's loops need."""
        return estimate.entries - sum(cost.shape.entries for cost in self.others)

    def _rest(self, function: Function) -> Function:
        if not self.others:
            return function
        if id(function) not in self._rests:
            self._rests[id(function)] = function, without_loops(function, self.headers)[0]
        return self._rests[id(function)][1]

    def _with_others(self, estimate: Estimate) -> Estimate:
        if not self.others:
            return estimate
        controller = self.estimator.fabric.controller
        switches = sum(cost.runs for cost in self.others) * controller.switch_cycles
        cycles = estimate.cycles + sum(cost.cycles for cost in self.others) + switches
        every = Estimate(cycles, (*estimate.regions, *self.others))
        return replace(every, cycles=math.inf) if every.contexts > controller.contexts else every


@dataclass(frozen=True)
class Regenerated:
    """A state with other loops for one of its parts.

    Attributes
    ----------
    loops
        Names of the loops, by the block that runs as often: their headers and bodies' branches.
    factor
        The most iterations that one of these loops runs together.
    carries
        Registers carry elements from one iteration to the next.
    """

    state: State
    loops: Mapping[str, str]
    factor: int
    carries: bool

    def hints(self, loops: Loops, symbols: Mapping[str, float]) -> dict[str, float]:
        """How often blocks run for other values of the symbols."""
        expected = expected_trips(loops, symbols)
        return {block: expected[name] for block, name in self.loops.items()}


def static_part(state: State, header: str) -> Scop | Refusal:
    """The nest at `header` as a static-control part."""
    scop = find_scop(with_own_latches(state.function, header), header)
    if isinstance(scop, Scop) and all(len(statement.dims) == 1 for statement in scop.statements):
        return Refusal("it is one loop, not a nest")
    return scop


def joined_parts(state: State) -> Iterator[tuple[str, State, Scop]]:
    """Two outermost nests of two loops, one right after the other, that go through one matrix, as
    one static-control part: the header of the first, the state with a loop around them, and the
    part.
    """
    loops = find_loops(state.function)
    outer = [one for one in loops if not any(one.header in o.blocks - {o.header} for o in loops)]
    for first, second in itertools.permutations(outer, 2) if len(outer) <= _MOST_JOINED else ():
        if between(state.function, first, second) is None:
            continue
        scops = [static_part(state, one.header) for one in (first, second)]
        shared = [_matrices(one) for one in scops if isinstance(one, Scop)]
        if len(shared) < len(scops) or not shared[0] & shared[1]:
            continue
        made = join(state.function, first, second)
        if isinstance(made, Refusal):
            continue
        hints = {**state.hints, made.header: 1.0}
        around = replace(state, function=made.function, hints=hints)
        part = static_part(around, made.header)
        if isinstance(part, Scop):
            yield first.header, around, part


def _matrices(scop: Scop) -> frozenset[str]:
    """Arrays of which each element is accessed in few iterations: of more subscripts than one, as
    many as there are loops at most.
    """
    if max(len(statement.dims) for statement in scop.statements) > _PLANE:
        return frozenset()
    accesses = [access for one in scop.statements for access in one.accesses.values()]
    return frozenset(one.array for one in accesses if len(one.subscripts) == _PLANE)


def expected_lengths(scop: Scop, trips: Mapping[str, float]) -> dict[str, float]:
    """What symbols are assumed to be, so that loops have the trips that are expected."""
    lengths = dict.fromkeys(scop.symbols, 16.0)
    for statement in scop.statements:
        for dim in statement.dims:
            first, limit = dim.bounds
            if len(limit.terms) == 1 and not first.terms:
                [(name, factor)] = limit.terms
                if factor == 1 and name in lengths:
                    expected = trips.get(dim.header, 16.0)
                    lengths[name] = expected + first.constant - limit.constant
    return lengths


def with_loops(
    state: State,
    scop: Scop,
    loops: Loops,
    symbols: Mapping[str, float],
    *,
    masks: bool = False,
    rows: Mapping[str, Rows] | None = None,
    carries: bool = True,
) -> Regenerated | Refusal:
    """The state with these loops for the part.

    Parameters
    ----------
    symbols
        What is expected of each.
    masks
        Whether loops are masked.
    rows
        Of arrays that have some.
    carries
        Whether registers carry elements from one iteration to the next.
    """
    made = generate(scop, loops, masks=masks, rows=rows, carries=carries, shares=True)
    if isinstance(made, Refusal):
        return made
    function = tidy(made.function)
    size = sum(len(block.instrs) for block in function.blocks)
    if size > MOST_INSTRUCTIONS:
        return Refusal(f"it would make {size} instructions")
    blocks = {new: loop.code.name for new, loop in made.loops.items()} | dict(made.branches)
    together = iterations_of(loops.code)
    origin = {new: state.origin.get(one.origin, one.origin) for new, one in made.loops.items()}
    scale = {
        new: state.scale.get(one.origin, 1) * together[one.code.name]
        for new, one in made.loops.items()
    }
    factor = max((loop.code.step for loop in made.loops.values()), default=1)
    found = Regenerated(state, blocks, factor, made.carries)
    changed = State(
        function,
        {**state.hints, **found.hints(loops, symbols)},
        state.made | made.loops.keys(),
        {**state.origin, **origin},
        {**state.scale, **scale},
    )
    return replace(found, state=changed)


def written_orders(scop: Scop) -> list[Scop]:
    """A part as it is, with what is computed before inner loops in them, and written with the loop
    of a sum outermost.
    """
    inside = sunk(scop)
    written = [scop] if inside is None else [scop, inside]
    return [*written, *realigned(Relations(written[-1]), _MOST_REALIGNED)]


def with_tree(
    state: State, header: str, order: int, tree: Loop, trips: Mapping[str, float]
) -> State | Refusal:
    """The state with the loops of a tree for the part at `header`, in one of its `written_orders`,
    if they keep its order.
    """
    scop = static_part(state, header)
    if isinstance(scop, Refusal):
        return scop
    orders = written_orders(scop)
    if order >= len(orders):
        return Refusal("its sums are elsewhere now")
    return _with_tree(state, orders[order], tree, trips)


def _with_tree(state: State, scop: Scop, tree: Loop, trips: Mapping[str, float]) -> State | Refusal:
    relations = Relations(scop)
    if not is_legal(tree, relations):
        return Refusal(_what_depends(relations, tree))
    loops = loops_of(tree, relations)
    if isinstance(loops, Refusal):
        return loops
    lengths = expected_lengths(scop, trips)
    made = with_loops(state, scop, loops, lengths, masks=has_masks(tree), rows=rows_of(tree))
    return made if isinstance(made, Refusal) else made.state


def jammed(state: State, header: str, factor: int, trips: Mapping[str, float]) -> State | Refusal:
    """Runs `factor` iterations of a loop together in the loops inside it (unroll-and-jam; Callahan,
    Cocke and Kennedy, "Estimating interlock and improving balance for pipelined architectures",
    1988). No operation is reassociated: each iteration keeps its own recurrences. What does not
    fill a group follows behind, or inside a group what must keep its order.
    """
    if not _holds_a_loop(state, header):
        return Refusal("no loop is inside it")
    scop = static_part(state, header)
    if isinstance(scop, Refusal):
        return scop
    tree = replace(tree_of(scop), factor=factor)
    made = _with_tree(state, scop, tree, trips)
    if isinstance(made, State):
        return made
    in_order = _with_tree(state, scop, replace(tree, in_order=True), trips)
    return in_order if isinstance(in_order, State) else made


def _what_depends(relations: Relations, tree: Loop) -> str:
    found = relations.accesses_out_of_order(schedule_of(tree, relations).get_map())
    if found is None:
        return "an iteration needs values of the one before"
    first, second = (
        f"{access.instr.mnemonic}{f' at {access.instr.loc}' if access.instr.loc else ''}"
        for access in found
    )
    return f"accesses to {found[0].array} depend on each other: {first} and {second}"


def _holds_a_loop(state: State, header: str) -> bool:
    blocks = state.loop(header).blocks
    return any(
        loop.header in blocks and loop.header != header for loop in find_loops(state.function)
    )
