"""Where two accesses of one array meet: by arithmetic, by a test, or as isl finds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, TypeAlias

import islpy as isl

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.analysis.counters import is_length
from vividc.ssa.analysis.induction import is_invariant
from vividc.ssa.analysis.polynomial import (
    ITERATION,
    LoopPolynomials,
    Monomial,
    Polynomial,
    constant,
)
from vividc.ssa.analysis.strides import Stride, stride_of
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop, flow_of
from vividc.ssa.ir import Const, Function, Input, Instr, Value, definition_of
from vividc.ssa.polyhedral.distances.in_rows import InRows, in_rows_of
from vividc.ssa.polyhedral.distances.linear import (
    STEEP,
    WORDS,
    Distances,
    Linear,
    Place,
    only_distances,
    solved,
)
from vividc.ssa.polyhedral.distances.maps import Maps, in_bytes, is_certain
from vividc.ssa.polyhedral.subscripts import Subscripts, subscripts_of
from vividc.ssa.polyhedral.values import Expressions, bounded, integer

_MOST_SEARCHES: Final = 150
"""Pairs of accesses of one loop, or of all straight code, that isl is asked about."""

_MOST_PREDICATED: Final = 48
"""Of these, pairs of straight code one of which is predicated: isl takes ten times as long for each
(covariance2 of NPBench compiled in 136 s in place of 93).
"""

_HALVINGS: Final = 3
"""Of a pair's operations, one for each pair before it that isl gave up on: where it gives up on one
it does on most that are like it, and what it finds there it finds in few operations or none (53 of
the pairs of solve_unit_lower's 5 by 5 iterations took 3.6 s of the 6 that it was planned in).
"""


@dataclass(frozen=True, slots=True)
class NotMore:
    """The signed word `less` is at most `more`; both are fixed in the loop."""

    less: Value
    more: Value


_Terms: TypeAlias = frozenset[tuple[Monomial, int]]


@dataclass(frozen=True, slots=True)
class _Known:
    """Of a place: its subscripts, if they are linear, and whether they are within its array."""

    place: Place
    linear: tuple[Linear, ...] | None
    in_array: bool


@dataclass
class Meetings:
    """Distances between the accesses of one iteration of `loop`, or of one block without a loop.

    `most_operations`: of isl, for one pair of accesses; as many take some 10 ms. `by_rows`: flat
    indices count as row and column.
    """

    function: Function
    loop: Loop | None = None
    most_operations: int = 20_000
    by_rows: bool = False
    _parts: dict[int, _Known] = field(init=False, default_factory=dict)
    """By the identity of the place, which is kept: many pairs ask for each."""
    _terms: dict[_Terms, _Terms] = field(init=False, default_factory=dict)
    """Equal ones are the same."""
    _strides: dict[Place, Stride | None] = field(init=False, default_factory=dict)
    _found: dict[tuple[Place, Place], Distances | None] = field(init=False, default_factory=dict)
    _given_up: int = field(init=False, default=0)
    _predicated: int = field(init=False, default=0)
    """Pairs that took isl more operations than they had."""

    @cached_property
    def _values(self) -> Expressions:
        if self.loop is None:
            return Expressions(self.function)
        return Expressions(self.function, (self.loop,), self._most_iterations(self.loop))

    @cached_property
    def _maps(self) -> Maps:
        return Maps(self.function, self._values, self._subscripts.of)

    @property
    def _subscripts(self) -> Subscripts | InRows:
        return in_rows_of(self.function) if self.by_rows else subscripts_of(self.function)

    @cached_property
    def _in_rows(self) -> Meetings | None:
        """The same by row and column, of straight code, where many elements of a few rows are."""
        return None if self.loop is not None or self.by_rows else replace(self, by_rows=True)

    @cached_property
    def _forms(self) -> LoopPolynomials | None:
        return None if self.loop is None else LoopPolynomials(self.function, self.loop)

    def _most_iterations(self, loop: Loop) -> int:
        """How many iterations `loop` can have, as accesses of all of them are in their arrays.

        An index that moves by a small step in each iteration would leave its array before it wraps.
        """
        most = WORDS
        flow = flow_of(self.function)
        for name in flow.dominators(loop.latches[0]):
            if name not in loop.blocks:
                break
            for instr in block_of(self.function, name).instrs:
                for part in self._subscripts.of(instr) or () if is_certain(instr) else ():
                    index = self._in_iteration(_not_from_end(part, self.function))
                    moved = 0 if index is None else abs(index.stride) << instr.shift
                    if 0 < moved < STEEP:
                        most = min(most, WORDS // moved + 2)
        return most

    def between(self, first: Place, second: Place, *, now: bool) -> Distances:
        """Of two accesses of one array; `now`: they may meet in one iteration."""
        if not (self._known(first).in_array and self._known(second).in_array):
            found: Distances | None = None
        elif (found := self._solved(first, second, now=now)) is None:
            found = self._stridden(first, second, now=now) or self._between_rows(first, second)
            found = found or self._searched(first, second, now=now)
        if found is None:
            found = Distances(int(not now), 1, assumed=True)
        is_loop = self.loop is not None or found.earlier is None
        return found if is_loop else Distances(found.later, None, found.assumed)

    def _between_rows(self, first: Place, second: Place) -> Distances | None:
        """Of two accesses in straight code by row and column, if these are known of both."""
        in_rows = self._in_rows
        if in_rows is None or None in map(
            in_rows_of(self.function).of, (first.instr, second.instr)
        ):
            return None
        return in_rows.between(first, second, now=True)

    def _solved(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        mine, theirs = self._linear(first), self._linear(second)
        if mine is None or theirs is None or len(mine) != len(theirs):
            return None
        return solved(first, mine, second, theirs, now=now)

    def _stridden(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        """Of subscripts that move by the same unknown number, which is known to be large enough
        where they do.
        """
        test = self._strides_apart(first, second)
        if test is None:
            return None
        with bounded(self.most_operations):
            if self._never_fails(test, first.block):
                same = test.less == Const(1)
                return Distances(0 if now and same else None, None)
        return None

    def _never_fails(self, test: NotMore, block: str) -> bool:
        """Whether a comparison holds wherever a block runs."""
        less, more = (self._values.of(value) for value in (test.less, test.more))
        if less is None or more is None:
            return False
        wrong = less.aff.gt_set(more.aff).intersect(self._values.domain(block))
        return bool(wrong.intersect(self._values.universe).is_empty())

    def _moving(self, place: Place) -> Stride | None:
        if place not in self._strides:
            self._strides[place] = self._stride(place) if self._is_in_each(place) else None
        return self._strides[place]

    def _strides_apart(self, first: Place, second: Place) -> NotMore | None:
        """A comparison that keeps accesses apart, in different iterations, whose subscripts move by
        the same fixed value: this is more than the number between them.
        """
        if self.loop is None:
            return None
        mine, theirs = (self._moving(place) for place in (first, second))
        if mine is None or theirs is None or (mine.by, mine.sign) != (theirs.by, theirs.sign):
            return None
        sizes = {(p.instr.width, p.instr.shift, p.instr.offset) for p in (first, second)}
        gap = theirs.rest.plus(mine.rest, -1).constant
        if gap is None or len(sizes) > 1 or first.instr.width != 1 << first.instr.shift:
            return None
        return NotMore(Const(abs(gap) + 1), mine.by)

    def _stride(self, place: Place) -> Stride | None:
        """How the only subscript of an access moves; None if it may count from the end."""
        parts = self._subscripts.of(place.instr)
        if parts is None or len(parts) > 1 or self._forms is None:
            return None
        raw = _not_from_end(parts[0], self.function)
        found = stride_of(raw, self._forms, self._is_fixed)
        return found if found is None or raw == parts[0] or found.never_wraps else None

    def _is_in_each(self, place: Place) -> bool:
        """Whether an access is made in each iteration."""
        assert self.loop is not None
        dominators = flow_of(self.function).dominators(self.loop.latches[0])
        return place.block in dominators and is_certain(place.instr)

    def _searched(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        """As isl finds them, of the first pairs that are asked for, if arithmetic does not rule
        them out; by row and column as arithmetic does.
        """
        if (first, second) not in self._found:
            only = self._only_distances(first, second)
            if only is not None and set(only) <= {0} and not (now and only):
                self._found[first, second] = Distances()
                return self._found[first, second]
            is_predicated = self._is_predicated(first, second)
            self._predicated += is_predicated
            is_over = is_predicated and self._predicated > _MOST_PREDICATED
            if self.by_rows or is_over or len(self._found) >= _MOST_SEARCHES:
                return None
            self._found[first, second] = None
            with bounded(self.most_operations >> min(self._given_up, _HALVINGS)):
                self._given_up += 1  # unless isl comes to an end
                self._found[first, second] = self.found_by_isl(first, second, int(not now), only)
                self._given_up -= 1
        return self._found[first, second]

    def _is_predicated(self, first: Place, second: Place) -> bool:
        """Whether one of two accesses in straight code is predicated."""
        are_certain = is_certain(first.instr) and is_certain(second.instr)
        return self.loop is None and not are_certain

    def _only_distances(self, first: Place, second: Place) -> tuple[int, ...] | None:
        """After how many iterations alone they may meet; None: any."""
        mine, theirs = self._linear(first), self._linear(second)
        if mine is None or theirs is None or first.instr.width != second.instr.width:
            return None
        return None if len(mine) != len(theirs) else only_distances(mine, theirs, first.instr.width)

    def found_by_isl(
        self, first: Place, second: Place, least: int, only: tuple[int, ...] | None
    ) -> Distances | None:
        mine, theirs = self._maps.of(first), self._maps.of(second)
        if mine is None or theirs is None or first.instr.width != second.instr.width:
            return None
        if _subscripts(mine) != _subscripts(theirs):
            return None
        if self.loop is None:
            met = mine.apply_range(theirs.reverse())
            return Distances(None if met.is_empty() else least, assumed=True)
        if only is not None:
            [distance] = only
            return _at(mine, theirs, distance, least)
        apart = mine.apply_range(theirs.reverse()).deltas()
        known = apart.project_out_all_params()
        later = _least(known.lower_bound_val(isl.dim_type.set, 0, isl.Val(least)))
        earlier = _least(known.upper_bound_val(isl.dim_type.set, 0, isl.Val(-1)).neg())
        ends = [later] if later is not None else []
        ends += [-earlier] if earlier is not None else []
        return Distances(later, earlier, assumed=not all(_always(mine, theirs, k) for k in ends))

    def tests_apart(self, store: Place, load: Place) -> tuple[NotMore, ...]:
        """Comparisons of fixed values, each of which rules out that the load meets the store in a
        later iteration; none if they do so for sure or never, or no comparison tells.
        """
        if not self.between(store, load, now=True).assumed:
            return ()
        test = self._strides_apart(store, load)
        if test is not None:
            return (test,)
        with bounded(4 * self.most_operations):
            mine, theirs = self._maps.of(store), self._maps.of(load)
            if mine is None or theirs is None or _subscripts(mine) != _subscripts(theirs):
                return ()
            apart = mine.apply_range(theirs.reverse()).deltas()
            met = apart.lower_bound_val(isl.dim_type.set, 0, isl.Val(1)).params()
            may_hold = mine.domain().params().intersect(theirs.domain().params())
            return tuple(self._excluding(met, may_hold))
        return ()

    def _excluding(self, met: isl.Set, may_hold: isl.Set) -> Iterator[NotMore]:
        """Comparisons that hold for none of these parameters, but for some that there may be."""
        hull = met.remove_divs().simple_hull()
        for constraint in hull.get_constraints():
            for sign in (1, -1) if constraint.is_equality() else (1,):
                test = self._contrary(constraint, sign)
                if test is None:
                    continue
                less, more = (self._values.of(value) for value in (test.less, test.more))
                if less is None or more is None:
                    continue
                holds = less.aff.le_set(more.aff).params()
                if holds.intersect(met).is_empty() and not holds.intersect(may_hold).is_empty():
                    yield test

    def _contrary(self, constraint: isl.Constraint, sign: int) -> NotMore | None:
        """What holds where a constraint does not, of one value and a number, or of two values."""
        number = -sign * integer(constraint.get_constant_val()) - 1
        terms: list[tuple[int, Value]] = []
        for key, position in self._values.parameters(constraint.get_space()):
            factor = integer(constraint.get_coefficient_val(isl.dim_type.param, position))
            if factor and isinstance(key, tuple):
                return None
            if factor and not isinstance(key, tuple):
                terms.append((-sign * int(factor), key))
        terms.sort(key=lambda term: term[0])
        if len(terms) == 1:
            [(factor, value)] = terms
            least, most = -(number // factor), number // -factor
            if factor > 0:
                return NotMore(Const(least % WORDS), value) if _is_word(least) else None
            return NotMore(value, Const(most % WORDS)) if _is_word(most) else None
        if number == 0 and [factor for factor, _ in terms] == [-1, 1]:
            return NotMore(terms[0][1], terms[1][1])
        return None

    def _linear(self, place: Place) -> tuple[Linear, ...] | None:
        """Subscripts as functions of the iteration index, in bytes; None if one is not linear."""
        return self._known(place).linear

    def _known(self, place: Place) -> _Known:
        known = self._parts.get(id(place))
        if known is None:
            parts = self._subscripts.of(place.instr)
            scaled = () if parts is None else in_bytes(parts, place.instr)
            found = [self._in_iteration(part) for part in scaled]
            linear = tuple(part for part in found if part is not None)
            whole = linear if parts and len(linear) == len(found) else None
            known = self._parts[id(place)] = _Known(place, whole, _in_array(place.instr))
        return known

    def _in_iteration(self, part: Polynomial) -> Linear | None:
        stride, rest = 0, Polynomial({})
        for monomial, factor in part.terms.items():
            if all(self._is_fixed(value) for value in monomial):
                rest = rest.plus(Polynomial({monomial: factor}))
                continue
            form = self._forms.of(monomial[0]) if self._forms and len(monomial) == 1 else None
            if form is None:
                return None
            stride += factor * form.coefficient(ITERATION)
            rest = rest.plus(constant(factor * form.coefficient()))
            for value, times in form.without(ITERATION).linear().items():
                rest = rest.plus(self._subscripts.polynomial(value), factor * times)
        terms = frozenset((monomial, factor) for monomial, factor in rest.terms.items() if monomial)
        return Linear(signed(stride), rest.coefficient(), self._terms.setdefault(terms, terms))

    def _is_fixed(self, value: Value) -> bool:
        """Whether each iteration has the same `value`."""
        return self.loop is None or is_invariant(self.function, self.loop.blocks, value)


def _in_array(instr: Instr) -> bool:
    base = instr.operands[0]
    return isinstance(base, Input) and base.key[0] == "&" and base.key[1:] == instr.array


def _is_word(number: int) -> bool:
    return -(WORDS // 2) <= number < WORDS // 2


def _not_from_end(part: Polynomial, function: Function) -> Polynomial:
    """A subscript without what is added to it where it is negative: the size, or 0."""
    terms = dict(part.terms)
    for monomial, factor in part.terms.items():
        item = definition_of(function, monomial[0]) if len(monomial) == 1 else None
        added = item.operands[1:] if isinstance(item, Instr) and item.op is Opcode.SELECT else ()
        if added and factor == 1 and is_length(added[0]) and added[1] == Const(0):
            del terms[monomial]
    return Polynomial(terms)


def _at(mine: isl.Map, theirs: isl.Map, later: int, least: int) -> Distances:
    """Of accesses that may meet only `later` iterations apart."""
    moved = theirs.apply_domain(_back(later))
    met = mine.intersect(moved).domain()
    if met.is_empty() or 0 <= later < least:
        return Distances()
    runs, met = mine.domain().intersect(moved.domain()).params(), met.params()
    equations = isl.Set.from_basic_set(met.affine_hull())  # they are soon seen not to hold
    assumed = not (runs.is_subset(equations) and runs.is_subset(met))
    return Distances(later, assumed=assumed) if later >= 0 else Distances(None, -later, assumed)


def _always(mine: isl.Map, theirs: isl.Map, later: int) -> bool:
    """Whether accesses `later` iterations apart meet whenever both run so, whatever the parameters
    are.
    """
    moved = theirs.apply_domain(_back(later))
    met = mine.intersect(moved).domain()
    runs = mine.domain().intersect(moved.domain())
    return bool(runs.params().is_subset(met.params()))


def _back(later: int) -> isl.Map:
    """From an iteration to one so many before it. It is not kept: reading it takes operations,
    which would depend on what was compiled before.
    """
    return isl.Map(f"{{ [i] -> [i - ({later})] }}")


def _subscripts(accessed: isl.Map) -> int:
    return accessed.dim(isl.dim_type.out)


def _least(distances: isl.Set) -> int | None:
    """The least of a set of numbers; None if it is empty.

    isl's own lexicographic minimum takes seconds where existential variables abound, and counts few
    operations for it.
    """
    while not distances.is_empty():
        least = distances.dim_min_val(0)  # may be too small
        if not distances.fix_val(isl.dim_type.set, 0, least).is_empty():
            return integer(least)
        distances = distances.lower_bound_val(isl.dim_type.set, 0, least.add(isl.Val(1)))
    return None
