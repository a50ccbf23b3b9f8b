"""Static-control parts are given other loops: interchanged, fused, tiled for registers.

Every tree of loops that is tried is legal by exact dependences; the estimate chooses among them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from vividc.compiler.planning.estimate import Estimator, Room
from vividc.compiler.planning.factors import (
    FACTORS,
    FIRST,
    LARGER,
    OF_SKEWED,
    OF_WAITING,
    PAYS,
    SMALLER,
    chosen,
    covers,
    crowded,
    filling,
    more,
    of_group,
)
from vividc.compiler.planning.parts import (
    Apart,
    Regenerated,
    Restructured,
    expected_lengths,
    ranked,
    static_part,
    surest,
    with_loops,
    written_orders,
)
from vividc.compiler.planning.state import State
from vividc.host import time_limit
from vividc.machine.opcodes import MEMORY
from vividc.ssa.polyhedral.loops import Loops, fors_in, loops_of, runs_in
from vividc.ssa.polyhedral.orders.search import (
    Path,
    at,
    describe,
    groups,
    groups_with_rows,
    has_masks,
    has_skews,
    is_legal,
    loops_in,
    orders,
    together,
    with_factors,
)
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.rows import rows_of
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal

_NEAR = 1.1
_MOST_NEAR = 2
_BETTER = 0.99
"""So many orders are given other factors, those that take up to so many times the cycles of the
best one with the first factors: with two rows and two columns each, blur3 by rows takes 1.02 times
what it takes by columns, and at its best 0.8 times. Another order is taken if it is so much better:
at an estimate of 0.993 symm takes 1.04 times its cycles, seidel-2d 0.93 times at one of 0.983.
"""

_MASKED = 0.97
"""Another mask is, if that is not for stalls alone: predicates leave a mapper less room (at 0.988
heat-3d takes 1.04 times), and stalls may be others (at 0.968 outer_product takes 1.34 times).
"""

_MOST_TRIES = 40
"""Trees of one part; each takes 0.1 to 1 s."""

_LARGER = 3
"""Symbols may be so many times as large as they are expected."""

_FAR = 1.5
"""Times the contexts: what takes more is not tried in other ways."""

_STORED = 0.6
"""Of the entries of constant stores beside load/store units, which nests share: what accesses of a
nest's loops take at most. Other operands and straight regions need the rest (adi: 8 rows of four
loops take 0.51 and are mapped, 10 take 0.64 and are not).
"""


def restructured(
    state: State,
    header: str,
    estimator: Estimator,
    trips: Mapping[str, float],
    most_operations: int,
) -> tuple[Restructured, ...] | Refusal:
    """The best loops for the part at `header`, none with more operations than `most_operations`;
    before them, if they nearly fill the contexts or have a large straight region, the best that are
    sure to be mapped, and likely.
    """
    scop = static_part(state, header)
    if isinstance(scop, Refusal):
        return scop
    symbols = expected_lengths(scop, trips)
    own, *others = (
        _Climb(state, order, part, estimator, symbols, most_operations)
        for order, part in enumerate(written_orders(scop))
    )
    least = min(map(_Climb.least, others), default=math.inf)
    tried = others if least * PAYS < own.as_written() else [own, *others]
    best = min(tried, key=_Climb.least)
    made = best.climb()
    made += [one for climb in (own, *others) if climb is not best for one in climb.made]
    every = [one for climb in (own, *others) for one in climb.made]
    return ranked(made, estimator, every) or Refusal("no other loops can be generated")


def restructured_together(
    state: State,
    part: Scop,
    estimator: Estimator,
    trips: Mapping[str, float],
    most_operations: int,
) -> tuple[Restructured, ...] | Refusal:
    """As `restructured`, of a part of two nests: the best loops in which they are one nest."""
    symbols = expected_lengths(part, trips)
    climb = _Climb(state, 0, part, estimator, symbols, most_operations, are_two=True)
    made = climb.climb()
    return ranked(made, estimator, made) or Refusal("they cannot be one nest")


@dataclass
class _Climb:
    state: State
    order: int
    scop: Scop
    estimator: Estimator
    symbols: Mapping[str, float]
    most_operations: int
    are_two: bool = False
    _tried: dict[str, Restructured | None] = field(default_factory=dict)
    _masked: dict[str, Restructured | None] = field(default_factory=dict)
    """As `_tried`: what differs in one mask from what was the best form."""
    _loops: dict[str, Loops | Refusal] = field(default_factory=dict)
    _last: tuple[str, bool, Regenerated | Refusal] | None = None
    """The tree that was written last, whether it carries, and its code."""
    _stored: float = _STORED
    """So large a part of the entries may be taken now: as many groups of loops have no factors yet,
    as many parts are left to them.
    """
    _smaller: int = 0
    """So many of the first factors take too many contexts in an order that was tried."""

    def __post_init__(self) -> None:
        self.relations = Relations(self.scop)
        self.contexts = self.estimator.fabric.controller.contexts
        self.larger = {name: _LARGER * length for name, length in self.symbols.items()}
        inside = {dim.header for one in self.scop.statements for dim in one.dims}
        function, hints = self.state.function, self.state.hints
        self.apart = Apart.of(self.estimator, function, hints, inside)

    @property
    def made(self) -> list[Restructured]:
        """All that was made."""
        return [one for one in self._tried.values() if one is not None]

    @cached_property
    def starts(self) -> list[tuple[float, Loop, list[tuple[Path, ...]]]]:
        """The orders with the fewest cycles, and what of them may be jammed, the best first."""
        tree = tree_of(self.scop)
        found = (together if self.are_two else orders)(tree, self.relations)
        ranked = sorted(map(self._ranked, found), key=lambda one: one[0])
        near = [one for one in ranked if one[0] < min(_NEAR * ranked[0][0], math.inf)]
        return near[:_MOST_NEAR]

    def least(self) -> float:
        """Cycles of the best order with the first factors."""
        return self.starts[0][0] if self.starts else math.inf

    def as_written(self) -> float:
        """Cycles of the part's own order with the first factors."""
        return self._ranked(tree_of(self.scop))[0]

    def climb(self) -> list[Restructured]:
        """Gives groups of loops of the best order factors, one group after the other; all that was
        made.
        """
        made: list[Restructured] = []
        for _, order, jammed in self.starts:
            tree = order
            for number, group in enumerate(jammed):
                self._stored = _STORED * (number + 1) / len(jammed)
                tree = self._jammed(tree, group)
            self._mask_otherwise()
            least = min((one.cycles for one in made), default=math.inf)
            if any(one.cycles < _BETTER * least for one in self.made):
                made = self.made
        return [*made, *self._with_loads(min(made, key=lambda one: one.cycles))] if made else []

    def _ranked(self, order: Loop) -> tuple[float, Loop, list[tuple[Path, ...]]]:
        ranked = [
            (min(self._cycles(tree), self._first(tree, jammed)), tree, jammed)
            for tree, jammed in self._ways(order)
        ]
        return min(ranked, key=lambda one: one[0])

    def _ways(self, order: Loop) -> Iterator[tuple[Loop, list[tuple[Path, ...]]]]:
        """An order with the loops to jam of it, and with temporaries that have rows."""
        tree, jammed = groups(order, self.relations)
        yield tree, jammed
        yield from groups_with_rows(order, self.relations)

    def _mask_otherwise(self) -> None:
        """Masks one loop after the other of the best form, if it is not masked, or no longer, where
        that is better: what columns next to each other load is carried if rows alone are masked.
        """
        best = min(self.made, key=lambda one: one.cycles, default=None)
        for path, loop in loops_in(best.tree) if best and not has_skews(best.tree) else ():
            assert best is not None
            tree = self._with(best.tree, {path: loop.factor}, not loop.masked)
            name = describe(tree)
            if loop.factor == 1 or name in self._tried:
                continue
            if name not in self._masked:
                is_possible = is_legal(tree, self.relations)
                self._masked[name] = self._made(tree) if is_possible else None
            made = self._masked[name]
            if made is None or made.cycles >= _MASKED * best.cycles:
                continue
            if made.estimate.least < best.estimate.least:
                best = self._tried[name] = made

    def _with_loads(self, best: Restructured) -> Iterator[Restructured]:
        """A form with loads of what iterations could carry, if that is better: what they carry is
        loaded before the loop.
        """
        made = self._made(best.tree, carries=False) if best.carries else None
        if made is not None and made.cycles < best.cycles:
            yield made

    def _first(self, tree: Loop, jammed: list[tuple[Path, ...]]) -> float:
        """Cycles with the first factors whose code fits into the contexts."""
        for pair, single in FIRST[self._smaller :]:
            first = OF_SKEWED if has_skews(tree) else pair
            given = dict(chosen(jammed, first, single))
            cycles = self._cycles(self._with(tree, given, self._is_better_masked(tree, given)))
            if cycles < math.inf:
                return cycles
            self._smaller = min(self._smaller + 1, len(FIRST) - 1)
        return math.inf

    def _is_better_masked(self, tree: Loop, given: Mapping[Path, int]) -> bool:
        """Whether what does not fill a group is masked, instead of behind the others: it takes less
        code, but for triangles, of which both are made.
        """
        if has_skews(tree):
            return True  # what some iterations of a group run would be long
        if self._is_far_too_long(self._with(tree, given, True)):
            return True
        masked = self._cycles(self._with(tree, given, True))
        if masked < math.inf and not self._is_triangle(tree, given):
            return True
        return masked < self._cycles(with_factors(tree, given))

    def _with(self, tree: Loop, given: Mapping[Path, int], masked: bool) -> Loop:
        """The tree with factors; nothing is masked where they divide lengths that are known."""
        lengths = {path: self._length(at(tree, path)) for path in given}
        needed = any(n is None or n % given[path] for path, n in lengths.items())
        return with_factors(tree, given, masked=masked and needed)

    def _is_far_too_long(self, tree: Loop) -> bool:
        """Whether it would take so many contexts that no such groups can fit."""
        most = _FAR * self.contexts
        made = self._try(tree)
        if made is not None and made.cycles == math.inf and made.estimate.contexts <= most:
            made = self._made(tree, most_contexts=most)
        return made is not None and made.estimate.contexts > most

    def _is_triangle(self, tree: Loop, given: Mapping[Path, int]) -> bool:
        """Whether bounds of a loop change from one iteration of these loops to the next."""
        loops = [at(tree, path) for path in given]
        for statement in self.scop.statements:
            counted = {loop.over.get(statement.name) for loop in loops}
            bounds = (bound for dim in statement.dims for bound in dim.bounds)
            if any(bound.names & counted for bound in bounds):
                return True
        return False

    def _jammed(self, tree: Loop, group: tuple[Path, ...]) -> Loop:
        """The tree with the best factors of a group of its loops, or none."""
        is_tile = has_skews(tree) and len(group) > 1
        first = OF_SKEWED if is_tile else FACTORS[len(group) == 1]
        masked = self._is_better_masked(tree, of_group(group, first))
        found = self._tried_factors(tree, group, first, masked=masked)
        trees = [tree, *found.values()]
        if not has_skews(tree):
            best = min(found, key=lambda one: self._cycles(found[one]))
            trees.append(self._with(tree, of_group(group, best), not masked))
        made = [one for one in map(self._try, trees) if one is not None]
        return surest(made, self.estimator).tree if made else tree

    def _tried_factors(
        self, tree: Loop, group: tuple[Path, ...], first: tuple[int, ...], *, masked: bool
    ) -> dict[tuple[int, ...], Loop]:
        """The tree with these factors of a group, and others that may be better."""
        plain = self._cycles(tree)
        is_tile = has_skews(tree) and len(group) > 1
        found: dict[tuple[int, ...], Loop] = {}
        failed: list[tuple[int, ...]] = []
        lengths = [self._length(at(tree, path)) for path in group]
        work = [*filling(lengths), first]
        while work or (work := more(self._cycles_of(found), first)):
            factors = work.pop(0)
            if factors in found or any(covers(factors, less) for less in failed):
                continue  # more are no smaller
            found[factors] = self._with(tree, of_group(group, factors), masked)
            cycles = self._cycles(found[factors])
            if cycles == math.inf:
                failed.append(factors)
            if cycles < plain:
                work += LARGER.get(factors, ())
                if self._waits(found[factors]):
                    work += OF_WAITING.get(factors, ())
            if cycles * PAYS > plain and not is_tile:
                work += SMALLER.get(factors, ())
        if None in lengths:
            for factors in crowded(self._cycles_of(found)):
                self._tried[describe(found.pop(factors))] = None
        return found

    def _cycles_of(self, found: Mapping[tuple[int, ...], Loop]) -> dict[tuple[int, ...], float]:
        return {factors: self._cycles(tree) for factors, tree in found.items()}

    def _waits(self, tree: Loop) -> bool:
        """Whether the hottest loop of a tree has as many operations again for free."""
        made = self._try(tree)
        hottest = None if made is None else made.estimate.loop(made.estimate.hottest)
        if hottest is None:
            return False
        shape, pes = hottest.shape, len(self.estimator.fabric.pes)
        return 2 * shape.operations <= shape.ii * pes

    def _length(self, loop: Loop) -> int | None:
        """How many iterations a loop has each time, if that is known."""
        dims = [
            dim
            for statement in self.scop.statements
            for dim in statement.dims
            if loop.over.get(statement.name) == dim.name
        ]
        if any(bound.terms for dim in dims for bound in dim.bounds):
            return None
        lengths = {limit.constant - first.constant for first, limit in (d.bounds for d in dims)}
        return lengths.pop() if len(lengths) == 1 else None

    def _cycles(self, tree: Loop) -> float:
        made = self._try(tree)
        return math.inf if made is None else made.cycles

    def _try(self, tree: Loop) -> Restructured | None:
        name = describe(tree)
        if name not in self._tried and len(self._tried) < _MOST_TRIES:
            time_limit.step("loops were restructured")
            legal = is_legal(tree, self.relations)
            self._tried[name] = self._made(tree) if legal else None
        return self._tried.get(name)

    def _made(
        self, tree: Loop, *, carries: bool = True, most_contexts: float | None = None
    ) -> Restructured | None:
        name = describe(tree)
        if name not in self._loops:
            self._loops[name] = loops_of(tree, self.relations)
        loops = self._loops[name]
        if isinstance(loops, Refusal) or self._is_too_large(loops):
            return None
        made = self._written(name, tree, loops, carries=carries)
        if isinstance(made, Refusal):
            return None
        hints = made.state.hints
        larger = {**hints, **made.hints(loops, self.larger)}
        room = Room(self.most_operations, most_contexts or self.contexts)
        estimate, large = self.apart.estimate(made.state.function, hints, larger, room=room)
        if self.estimator.largest_loop(estimate) > self.most_operations:
            return None
        mean = math.sqrt(estimate.cycles * large.cycles)
        if self.apart.entries(estimate) > self._stored * self.estimator.entries:
            return None
        order, factor, carries = self.order, made.factor, made.carries
        return Restructured(made.state, estimate, order, tree, factor, mean, carries)

    def _written(
        self, name: str, tree: Loop, loops: Loops, *, carries: bool
    ) -> Regenerated | Refusal:
        """The state with the loops of a tree: the same one if it is asked for twice in a row."""
        if self._last is None or self._last[:2] != (name, carries):
            given = self.state, self.scop, loops, self.symbols
            masks, rows = has_masks(tree), rows_of(tree)
            made = with_loops(*given, masks=masks, rows=rows, carries=carries)
            self._last = name, carries, made
        return self._last[2]

    def _is_too_large(self, loops: Loops) -> bool:
        """Whether an innermost loop is sure to have too many operations, even if two instructions
        become one each time and its accesses are saved.
        """
        work = {
            statement.name: sum(instr.op not in MEMORY for instr in statement.instrs)
            for statement in self.scop.statements
        }
        return any(
            sum(work[run.statement] for run in runs_in(loop.body)) > 2 * self.most_operations
            for loop in fors_in(loops.code)
            if not any(fors_in(loop.body))
        )
