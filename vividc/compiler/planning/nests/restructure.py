"""Static-control parts are given other loops: interchanged, fused, tiled for registers.

Every tree of loops that is tried is legal by exact dependences; the estimate chooses among them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.nests.factors import (
    FACTORS,
    FIRST,
    LARGER,
    OF_SKEWED,
    OF_WAITING,
    PAYS,
    SMALLER,
    are_masks_felt,
    are_past_the_best,
    chosen,
    covers,
    crowded,
    filling,
    more,
    of_group,
)
from vividc.compiler.planning.nests.parts import (
    Restructured,
    expected_lengths,
    ranked,
    static_part,
    surest,
    written_orders,
)
from vividc.compiler.planning.nests.trees import STORED, Trees, side_by_side
from vividc.compiler.planning.state import State
from vividc.ssa.polyhedral.orders.in_memory import in_memory
from vividc.ssa.polyhedral.orders.joined import divided, together
from vividc.ssa.polyhedral.orders.search import (
    Path,
    at,
    describe,
    groups,
    groups_with_rows,
    has_skews,
    loops_in,
    orders,
    with_factors,
    with_factors_of,
)
from vividc.ssa.polyhedral.relations import Relations
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

_CLEARLY = 1.1
"""Where masks (or none) are so much better with the first factors, none (or masks) are not tried
with the best ones: of 22 groups of triangles (234 kernels, NPBench) they are in 15, and would not
be better with the best ones in any.
"""

_LONGER = 1.25
"""Times the contexts of a masked triangle, what takes none takes at least: of 40 triangles of
NPBench one took 1.26, the others more. Where the masked one has no room, none of 30 had.
"""

_HOPELESS = 2.5
"""Of the cycles of the best form so far: a masked triangle that takes more is not the better one
without, which takes 0.54 times as many at least (syrk).
"""

_FAR = 1.5
"""Times the contexts: what takes more is not tried in other ways."""


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
    climbs = [
        _Climb(Trees(state, order, part, estimator, symbols, most_operations))
        for order, part in enumerate(written_orders(scop))
    ]
    with side_by_side([climb.trees for climb in climbs]):
        made, every = _climbed(*climbs)
    return ranked(made, estimator, every) or Refusal("no other loops can be generated")


def _climbed(own: _Climb, *others: _Climb) -> tuple[list[Restructured], list[Restructured]]:
    """What the best of a part's orders makes and what was made of the others, and all of it."""
    for climb in others:
        climb.expect_orders()
    least = min(map(_Climb.least, others), default=math.inf)
    tried = others if least * PAYS < own.as_written() else [own, *others]
    best = min(tried, key=_Climb.least)
    made = best.climb()
    made += [one for climb in (own, *others) if climb is not best for one in climb.trees.all_made]
    return made, [one for climb in (own, *others) for one in climb.trees.all_made]


def restructured_together(
    state: State,
    part: Scop,
    estimator: Estimator,
    trips: Mapping[str, float],
    most_operations: int,
) -> tuple[Restructured, ...] | Refusal:
    """As `restructured`, of a part of two nests: the best loops in which they are one nest."""
    symbols = expected_lengths(part, trips)
    found = {together: part, divided: in_memory(part)}
    climbs = [
        _Climb(Trees(state, order, one, estimator, symbols, most_operations), of_two=search)
        for order, (search, one) in enumerate(found.items())
    ]
    with side_by_side([climb.trees for climb in climbs]):
        for climb in climbs:
            climb.expect_orders()
        made = min(climbs, key=_Climb.least).climb()
    return ranked(made, estimator, made) or Refusal("they cannot be one nest")


_Way = tuple[Loop, list[tuple[Path, ...]]]
"""An order with the loops to jam of it, which may have rows of temporaries."""

_Try = tuple[tuple[int, ...], tuple[int, ...]]
"""Factors, and the smaller ones that have led to them, if any have; else the same ones."""


@dataclass
class _Climb:
    """The search for the best tree of one of a part's orders.

    `of_two`: what finds the orders of a part of two nests, if it is one.
    `_masked`: as `tried` of the trees, what differs in one mask from what was the best form.
    `_smaller`: so many of the first factors take too many contexts in an order that was tried.
    """

    trees: Trees
    of_two: Callable[[Loop, Relations], Iterable[Loop]] | None = None
    _masked: dict[str, Restructured | None] = field(default_factory=dict)
    _smaller: int = 0

    @cached_property
    def _orders(self) -> list[list[_Way]]:
        """The orders, each in several ways."""
        tree = tree_of(self.trees.scop)
        found = (self.of_two or orders)(tree, self.trees.relations)
        return [list(self._ways(order)) for order in found]

    def expect_orders(self) -> None:
        """Has orders made ahead, with the first factors."""
        self.trees.expect(
            one
            for ways in self._orders
            for tree, jammed in ways
            for one in (tree, self._with(tree, self._first_factors(tree, jammed), True))
        )

    @cached_property
    def starts(self) -> list[tuple[float, Loop, list[tuple[Path, ...]]]]:
        """The orders with the fewest cycles, and what of them may be jammed, the best first."""
        self.expect_orders()
        ranked = sorted(map(self._ranked, self._orders), key=lambda one: one[0])
        near = [one for one in ranked if one[0] < min(_NEAR * ranked[0][0], math.inf)]
        return near[: 1 if self.of_two else _MOST_NEAR]

    def least(self) -> float:
        """Cycles of the best order with the first factors."""
        return self.starts[0][0] if self.starts else math.inf

    def as_written(self) -> float:
        """Cycles of the part's own order with the first factors."""
        return self._ranked(list(self._ways(tree_of(self.trees.scop))))[0]

    def climb(self) -> list[Restructured]:
        """Gives groups of loops of the best order factors, one group after the other; all that was
        made.
        """
        made: list[Restructured] = []
        for _, order, jammed in self.starts[:1]:
            self._expect_factors(order, jammed)
        for _, order, jammed in self.starts:
            if made and not self._is_promising(order, min(made, key=lambda one: one.cycles)):
                continue
            tree = order
            self.trees.allow(len(jammed))
            for number, group in enumerate(jammed):
                self.trees.stored = STORED * (number + 1) / len(jammed)
                tree = self._jammed(tree, group, is_last=number + 1 == len(jammed))
            self._mask_otherwise()
            least = min((one.cycles for one in made), default=math.inf)
            if any(one.cycles < _BETTER * least for one in self.trees.all_made):
                made = self.trees.all_made
        return [*made, *self._with_loads(min(made, key=lambda one: one.cycles))] if made else []

    def _is_promising(self, order: Loop, best: Restructured) -> bool:
        """Whether an order is better than the best of another one with its factors, of the same
        loops or of those in the same places: else it is not given others.
        """
        alike = with_factors_of(order, best.tree)
        self.trees.expect(alike)
        return any(self.trees.cycles(tree) < _BETTER * best.cycles for tree in alike)

    def _expect_factors(self, tree: Loop, jammed: list[tuple[Path, ...]]) -> None:
        """Has an order's first group made ahead with the factors that will be tried, where it is
        known what they are.
        """
        for group in jammed[:1]:
            given = of_group(group, self._first(tree, group))
            if describe(self._with(tree, given, True)) in self.trees.tried:
                before, self.trees.stored = self.trees.stored, STORED / len(jammed)
                first, masked = self._first(tree, group), self._is_better_masked(tree, given)
                lengths = [self._length(at(tree, path)) for path in group]
                tries = [(factors, factors) for factors in (*filling(lengths), first)]
                tries += self._following(tree, group, first, self._with(tree, given, masked))
                self._expect_tries(tree, group, tries, masked=masked)
                self.trees.stored = before

    def _ranked(self, ways: list[_Way]) -> tuple[float, Loop, list[tuple[Path, ...]]]:
        ranked = [
            (min(self.trees.cycles(tree), self._at_first(tree, jammed)), tree, jammed)
            for tree, jammed in ways
        ]
        return min(ranked, key=lambda one: one[0])

    def _ways(self, order: Loop) -> Iterator[_Way]:
        tree, jammed = groups(order, self.trees.relations)
        yield tree, sorted(jammed, key=len, reverse=True) if self.of_two else jammed
        yield from groups_with_rows(order, self.trees.relations)

    def _mask_otherwise(self) -> None:
        """Masks one loop after the other of the best form, if it is not masked, or no longer, where
        that may be better: what columns next to each other load is carried if rows alone are
        masked, and rows of which the loops inside have other lengths each have a mask in them.
        """
        best = self._expect_otherwise()
        if best is None:
            return
        for path, loop in self._to_be_masked_otherwise(best.tree):
            tree = self._otherwise(best.tree, path, loop)
            name = describe(tree)
            if name in self.trees.tried:
                continue
            if name not in self._masked:
                self._masked[name] = self.trees.outcome(tree)
            made = self._masked[name]
            if made is None or made.cycles >= _MASKED * best.cycles:
                continue
            if made.estimate.least < best.estimate.least:
                best = self.trees.tried[name] = made

    def _expect_otherwise(self) -> Restructured | None:
        """Has the best form so far made ahead with one mask changed; None: it has no other ones."""
        best = min(self.trees.all_made, key=lambda one: one.cycles, default=None)
        if best is None or has_skews(best.tree):
            return None
        loops = self._to_be_masked_otherwise(best.tree)
        trees = (self._otherwise(best.tree, path, loop) for path, loop in loops)
        self.trees.expect(tree for tree in trees if describe(tree) not in self._masked)
        return best

    def _to_be_masked_otherwise(self, tree: Loop) -> list[tuple[Path, Loop]]:
        """Loops with factors that may be better masked, or no longer: other masks are outside of
        innermost loops (of 40 forms of NPBench without one, none was better by `_MASKED`).
        """
        return [
            (path, loop)
            for path, loop in loops_in(tree)
            if loop.factor > 1
            if not loop.masked or _is_innermost(loop) or are_masks_felt(tree, loop, self.trees.scop)
        ]

    def _otherwise(self, tree: Loop, path: Path, loop: Loop) -> Loop:
        """The tree with this loop of it masked, or no longer."""
        return self._with(tree, {path: loop.factor}, not loop.masked)

    def _with_loads(self, best: Restructured) -> Iterator[Restructured]:
        """A form with loads of what iterations could carry, if that is better: what they carry is
        loaded before the loop.
        """
        made = self.trees.made(best.tree, carries=False) if best.carries else None
        if made is not None and made.cycles < best.cycles:
            yield made

    def _at_first(self, tree: Loop, jammed: list[tuple[Path, ...]]) -> float:
        """Cycles with the first factors whose code fits into the contexts."""
        while True:
            given = self._first_factors(tree, jammed)
            masked = self._is_better_masked(tree, given)
            cycles = self.trees.cycles(self._with(tree, given, masked))
            if cycles < math.inf or self._smaller == len(FIRST) - 1:
                return cycles
            self._smaller += 1

    def _first_factors(self, tree: Loop, jammed: list[tuple[Path, ...]]) -> dict[Path, int]:
        pair, single = FIRST[self._smaller]
        return dict(chosen(jammed, OF_SKEWED if has_skews(tree) else pair, single))

    def _is_better_masked(self, tree: Loop, given: Mapping[Path, int]) -> bool:
        """Whether what does not fill a group is masked, instead of behind the others: it takes less
        code, but for triangles, of which both are made if there may be room.
        """
        if has_skews(tree):
            return True  # what some iterations of a group run would be long
        masked = self._with(tree, given, True)
        self.trees.expect([masked])
        if self._is_far_too_long(masked):
            return True
        made = self.trees.attempt(masked)
        if made is not None and not (self._is_triangle(tree, given) and self._may_do_without(made)):
            return True
        return self.trees.cycles(masked) < self.trees.cycles(with_factors(tree, given))

    def _may_do_without(self, masked: Restructured) -> bool:
        """Whether there may be room for what is masked behind the others, and cycles to gain."""
        least = min(one.cycles for one in self.trees.all_made)
        contexts = masked.estimate.contexts + (_LONGER - 1.0) * self.trees.own_contexts(masked)
        return masked.cycles < _HOPELESS * least and contexts <= self.trees.contexts

    def _is_clear(self, tree: Loop, given: Mapping[Path, int]) -> bool:
        """Whether it makes much of a difference to these factors if loops are masked, or none was
        tried without and no loop inside feels the masks.
        """
        masked = self._with(tree, given, True)
        pair = [describe(masked), describe(with_factors(tree, given))]
        if pair[-1] not in self.trees.tried:
            loops, scop = [at(masked, path) for path in given], self.trees.scop
            felt = any(are_masks_felt(masked, loop, scop) for loop in loops)
            return self._is_triangle(tree, given) or not felt
        both = map(self.trees.tried.get, pair)
        cycles = [math.inf if one is None else one.cycles for one in both]
        return _CLEARLY * min(cycles) < max(cycles) < math.inf

    def _with(self, tree: Loop, given: Mapping[Path, int], masked: bool) -> Loop:
        """The tree with factors; nothing is masked where they divide lengths that are known."""
        lengths = {path: self._length(at(tree, path)) for path in given}
        needed = any(n is None or n % given[path] for path, n in lengths.items())
        return with_factors(tree, given, masked=masked and needed)

    def _is_far_too_long(self, tree: Loop) -> bool:
        """Whether it would take so many contexts that no such groups can fit."""
        most = _FAR * self.trees.contexts
        made = self.trees.attempt(tree)
        if made is not None and made.cycles == math.inf and made.estimate.contexts <= most:
            made = self.trees.made(tree, most_contexts=most)
        return made is not None and made.estimate.contexts > most

    def _is_triangle(self, tree: Loop, given: Mapping[Path, int]) -> bool:
        """Whether bounds of a loop change from one iteration of these loops to the next."""
        loops = [at(tree, path) for path in given]
        for statement in self.trees.scop.statements:
            counted = {loop.over.get(statement.name) for loop in loops}
            bounds = (bound for dim in statement.dims for bound in dim.bounds)
            if any(bound.names & counted for bound in bounds):
                return True
        return False

    def _first(self, tree: Loop, group: tuple[Path, ...]) -> tuple[int, ...]:
        """The factors of a group that are tried first."""
        return OF_SKEWED if _is_tile(tree, group) else FACTORS[len(group) == 1]

    def _jammed(self, tree: Loop, group: tuple[Path, ...], *, is_last: bool) -> Loop:
        """The tree with the best factors of a group of its loops, or none. After the last one the
        best form of all is masked otherwise, mostly one that is known before all have been tried.
        """
        first = of_group(group, self._first(tree, group))
        masked = self._is_better_masked(tree, first)
        found = self._tried_factors(tree, group, masked=masked)
        trees = [tree, *found.values()]
        if not (has_skews(tree) or self._is_clear(tree, first)):
            best = min(found, key=lambda one: self.trees.cycles(found[one]))
            trees.append(self._with(tree, of_group(group, best), not masked))
        if is_last:
            self._expect_otherwise()
        made = [one for one in map(self.trees.attempt, trees) if one is not None]
        return surest(made, self.trees.estimator).tree if made else tree

    def _tried_factors(
        self, tree: Loop, group: tuple[Path, ...], *, masked: bool
    ) -> dict[tuple[int, ...], Loop]:
        """The tree with the first factors of a group, and others that may be better."""
        first = self._first(tree, group)
        found: dict[tuple[int, ...], Loop] = {}
        failed: list[tuple[int, ...]] = []
        lengths = [self._length(at(tree, path)) for path in group]
        work = [(factors, factors) for factors in (*filling(lengths), first)]
        self._expect_tries(tree, group, work, masked=masked)
        while work or (work := [(one, one) for one in more(self._cycles_of(found), first)]):
            factors, smaller = work.pop(0)
            if factors in found or any(covers(factors, less) for less in failed):
                continue  # more are no smaller
            if are_past_the_best(self._cycles_of(found), smaller):
                continue
            found[factors] = self._with(tree, of_group(group, factors), masked)
            if self.trees.cycles(found[factors]) == math.inf:
                failed.append(factors)
            following = self._following(tree, group, factors, found[factors])
            work += following
            self._expect_tries(tree, group, following, masked=masked)
        if None in lengths:
            for factors in crowded(self._cycles_of(found)):
                self.trees.tried[describe(found.pop(factors))] = None
        return found

    def _following(
        self, tree: Loop, group: tuple[Path, ...], factors: tuple[int, ...], given: Loop
    ) -> list[_Try]:
        """Factors to be tried after these, with which a tree is `given`."""
        plain, cycles = self.trees.cycles(tree), self.trees.cycles(given)
        following: list[tuple[int, ...]] = []
        if cycles * PAYS > plain and not _is_tile(tree, group):
            following += SMALLER.get(factors, ())
        if cycles < plain:
            following += LARGER.get(factors, ())
            if self._waits(given):
                following += OF_WAITING.get(factors, ())
        return [(one, factors if covers(one, factors) else one) for one in following]

    def _expect_tries(
        self, tree: Loop, group: tuple[Path, ...], tries: Iterable[_Try], *, masked: bool
    ) -> None:
        """Has the tree made ahead with these factors of a group."""
        self.trees.expect(self._with(tree, of_group(group, one), masked) for one, _ in tries)

    def _cycles_of(self, found: Mapping[tuple[int, ...], Loop]) -> dict[tuple[int, ...], float]:
        return {factors: self.trees.cycles(tree) for factors, tree in found.items()}

    def _waits(self, tree: Loop) -> bool:
        """Whether the hottest loop of a tree has as many operations again for free."""
        made = self.trees.attempt(tree)
        hottest = None if made is None else made.estimate.loop(made.estimate.hottest)
        if hottest is None:
            return False
        shape, pes = hottest.shape, len(self.trees.estimator.fabric.pes)
        return 2 * shape.operations <= shape.ii * pes

    def _length(self, loop: Loop) -> int | None:
        """How many iterations a loop has each time, if that is known."""
        dims = [
            dim
            for statement in self.trees.scop.statements
            for dim in statement.dims
            if loop.over.get(statement.name) == dim.name
        ]
        if any(bound.terms for dim in dims for bound in dim.bounds):
            return None
        lengths = {limit.constant - first.constant for first, limit in (d.bounds for d in dims)}
        return lengths.pop() if len(lengths) == 1 else None


def _is_innermost(loop: Loop) -> bool:
    return not any(isinstance(child, Loop) for child in loop.children)


def _is_tile(tree: Loop, group: tuple[Path, ...]) -> bool:
    """Whether iterations of a group are run together in the order of diagonals."""
    return has_skews(tree) and len(group) > 1
