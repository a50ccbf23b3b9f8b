"""Over how many iterations of a loop two accesses of one array touch one byte."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import islpy as isl

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.machine.params import MAX_ELEMENTS
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
from vividc.ssa.polyhedral.subscripts import Subscripts, subscripts_of
from vividc.ssa.polyhedral.values import Expression, Expressions, integer

_MOST_SEARCHES: Final = 150
"""Pairs of accesses of one loop, or of all straight code, that isl is asked about."""
_STEEP: Final = 1 << 15
"""Words that move by less wrap after more iterations than any schedule has under way."""
_WORDS: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Place:
    """An access in a block."""

    instr: Instr
    block: str


@dataclass(frozen=True, slots=True)
class Distances:
    """Of two accesses, the second behind the first in the program.

    Attributes
    ----------
    later
        The least number of iterations, from 0 on, after which the second touches what the first
        has touched; None: never.
    earlier
        The least number from 1 on after which the first touches what the second has touched.
    assumed
        They may, for all that is known: whether they do depends on parameters, or it took too long
        to find out.
    """

    later: int | None = None
    earlier: int | None = None
    assumed: bool = False


@dataclass(frozen=True, slots=True)
class NotMore:
    """The signed word `less` is at most `more`; both are fixed in the loop."""

    less: Value
    more: Value


@dataclass
class Meetings:
    """Distances between the accesses of one iteration of `loop`, or of one block without a loop.

    `most_operations`: of isl, for one pair of accesses; as many take some 10 ms.
    """

    function: Function
    loop: Loop | None = None
    most_operations: int = 20_000
    _parts: dict[Place, tuple[_Linear, ...] | None] = field(init=False, default_factory=dict)
    _exact: dict[Place, isl.Map | None] = field(init=False, default_factory=dict)
    _found: dict[tuple[Place, Place], Distances | None] = field(init=False, default_factory=dict)

    @cached_property
    def _values(self) -> Expressions:
        if self.loop is None:
            return Expressions(self.function)
        return Expressions(self.function, (self.loop,), self._most_iterations(self.loop))

    @property
    def _subscripts(self) -> Subscripts:
        return subscripts_of(self.function)

    @cached_property
    def _forms(self) -> LoopPolynomials | None:
        return None if self.loop is None else LoopPolynomials(self.function, self.loop)

    def _most_iterations(self, loop: Loop) -> int:
        """How many iterations `loop` can have, as accesses of all of them are in their arrays.

        An index that moves by a small step in each iteration would leave its array before it wraps.
        """
        most = _WORDS
        flow = flow_of(self.function)
        for name in flow.dominators(loop.latches[0]):
            if name not in loop.blocks:
                break
            for instr in block_of(self.function, name).instrs:
                for part in self._subscripts.of(instr) or () if _is_certain(instr) else ():
                    index = self._in_iteration(_not_from_end(part, self.function))
                    moved = 0 if index is None else abs(index.stride) << instr.shift
                    if 0 < moved < _STEEP:
                        most = min(most, _WORDS // moved + 2)
        return most

    def between(self, first: Place, second: Place, *, now: bool) -> Distances:
        """Of two accesses of one array; `now`: they may meet in one iteration."""
        if not (self._in_array(first) and self._in_array(second)):
            found: Distances | None = None
        elif (found := self._solved(first, second, now=now)) is None:
            found = self._stridden(first, second, now=now)
            found = found or self._searched(first, second, now=now)
        if found is None:
            found = Distances(int(not now), 1, assumed=True)
        return found if self.loop is not None else replace(found, earlier=None)

    def _in_array(self, place: Place) -> bool:
        return place.instr.operands[0] == Input(f"&{place.instr.array}")

    def _solved(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        mine, theirs = self._linear(first), self._linear(second)
        if mine is None or theirs is None or len(mine) != len(theirs):
            return None
        return _solved(first, mine, second, theirs, now=now)

    def _stridden(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        """Of subscripts that move by the same unknown number, which is known to be large enough
        where they do.
        """
        test = self._strides_apart(first, second)
        if test is None:
            return None
        less, more = (self._values.of(value) for value in (test.less, test.more))
        if less is None or more is None:
            return None
        wrong = less.aff.gt_set(more.aff).intersect(self._values.domain(first.block))
        if not wrong.intersect(self._values.universe).is_empty():
            return None
        same = test.less == Const(1)
        return Distances(0 if now and same else None, None)

    def _strides_apart(self, first: Place, second: Place) -> NotMore | None:
        """A comparison that keeps accesses apart, in different iterations, whose subscripts move by
        the same fixed value: this is more than the number between them.
        """
        if self._forms is None or not self._is_in_each(first) or not self._is_in_each(second):
            return None
        mine, theirs = self._stride(first), self._stride(second)
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
        return place.block in dominators and _is_certain(place.instr)

    def _searched(self, first: Place, second: Place, *, now: bool) -> Distances | None:
        """As isl finds them."""
        if (first, second) not in self._found:
            if len(self._found) == _MOST_SEARCHES:
                return None
            self._found[first, second] = None
            with _bounded(self.most_operations):
                self._found[first, second] = self._ends(first, second, int(not now))
        return self._found[first, second]

    def _ends(self, first: Place, second: Place, least: int) -> Distances | None:
        mine, theirs = self._map(first), self._map(second)
        if mine is None or theirs is None or first.instr.width != second.instr.width:
            return None
        if _subscripts(mine) != _subscripts(theirs):
            return None
        met = mine.apply_range(theirs.reverse())
        if self.loop is None:
            return Distances(None if met.is_empty() else least, assumed=True)
        apart = met.deltas()
        known = apart.project_out_all_params()
        later = _least(known.lower_bound_val(isl.dim_type.set, 0, isl.Val(least)))
        earlier = _least(known.upper_bound_val(isl.dim_type.set, 0, isl.Val(-1)).neg())
        ends = [later] if later is not None else []
        ends += [-earlier] if earlier is not None else []
        run = mine.domain(), theirs.domain()
        return Distances(later, earlier, assumed=not all(_always(apart, *run, k) for k in ends))

    def tests_apart(self, store: Place, load: Place) -> tuple[NotMore, ...]:
        """Comparisons of fixed values, each of which rules out that the load meets the store in a
        later iteration; none if they do so for sure or never, or no comparison tells.
        """
        if not self.between(store, load, now=True).assumed:
            return ()
        test = self._strides_apart(store, load)
        if test is not None:
            return (test,)
        with _bounded(4 * self.most_operations):
            mine, theirs = self._map(store), self._map(load)
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
                return NotMore(Const(least % _WORDS), value) if _is_word(least) else None
            return NotMore(value, Const(most % _WORDS)) if _is_word(most) else None
        if number == 0 and [factor for factor, _ in terms] == [-1, 1]:
            return NotMore(terms[0][1], terms[1][1])
        return None

    def _in_bytes(self, place: Place) -> tuple[Polynomial, ...] | None:
        """Subscripts times the bytes from one index to the next; the last with the offset."""
        parts = self._subscripts.of(place.instr)
        if parts is None:
            return None
        *outer, last = (part.times(constant(1 << place.instr.shift)) for part in parts)
        return (*outer, last.plus(constant(place.instr.offset)))

    def _linear(self, place: Place) -> tuple[_Linear, ...] | None:
        """Subscripts as functions of the iteration index, in bytes; None if one is not linear."""
        if place not in self._parts:
            parts = self._in_bytes(place)
            found = [self._in_iteration(part) for part in parts or ()]
            known = tuple(part for part in found if part is not None)
            self._parts[place] = known if parts and len(known) == len(found) else None
        return self._parts[place]

    def _in_iteration(self, part: Polynomial) -> _Linear | None:
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
        return _Linear(signed(stride), rest.coefficient(), terms)

    def _map(self, place: Place) -> isl.Map | None:
        """From iterations to the element that the access is to, by its subscripts; None if it is to
        parts of elements.
        """
        if place not in self._exact:
            self._exact[place] = None
            instr = place.instr
            parts = self._subscripts.of(instr)
            words = _WORDS
            if parts is not None and (instr.width != 1 << instr.shift or instr.offset):
                parts = _divided(self._in_bytes(place) or (), instr.width)
                words //= instr.width
            if parts is not None:
                self._exact[place] = self._subscript_map(place, parts, words)
        return self._exact[place]

    def _subscript_map(
        self, place: Place, parts: tuple[Polynomial, ...], words: int
    ) -> isl.Map | None:
        """Of subscripts that are known modulo `words`."""
        found: isl.Map | None = None
        domain = self._runs(place)
        for axis, part in enumerate(parts):
            subscript = self._sum(part)
            if subscript is None:
                return None
            extent = self._extent(place.instr, axis, len(parts))
            if subscript.low < extent.high - words or subscript.high >= words:
                subscript = subscript.modulo(words)  # else one in its bounds is the sum itself
            domain = domain.intersect(subscript.aff.ge_set(self._values.constant(0).aff))
            domain = domain.intersect(subscript.aff.lt_set(extent.aff))
            single = isl.Map.from_pw_aff(subscript.aff)
            found = single if found is None else found.flat_range_product(single)
        return (
            None
            if found is None
            else found.intersect_domain(domain.intersect(self._values.universe))
        )

    def _runs(self, place: Place) -> isl.Set:
        """Iterations in which an access may be made: its predicate says so, too."""
        domain = self._values.domain(place.block)
        if _is_certain(place.instr):
            return domain
        held = self._values.holds(place.instr.operands[-1], True)
        return domain if held is None else domain.intersect(held)

    def _is_fixed(self, value: Value) -> bool:
        """Whether each iteration has the same `value`."""
        return self.loop is None or is_invariant(self.function, self.loop.blocks, value)

    def _sum(self, part: Polynomial) -> Expression | None:
        total = self._values.constant(0)
        for monomial, factor in part.terms.items():
            value = self._product(monomial)
            if value is None:
                return None
            total = total.plus(value, factor)
        return total

    def _product(self, monomial: Monomial) -> Expression | None:
        if not monomial:
            return self._values.constant(1)
        if len(monomial) == 1:
            return self._values.of(monomial[0])
        fixed = all(self._is_fixed(value) for value in monomial)
        return self._values.symbol(monomial) if fixed else None

    def _extent(self, instr: Instr, axis: int, axes: int) -> Expression:
        """What a subscript is less than."""
        param = next((p for p in self.function.params if p.name == instr.array), None)
        if param is None or param.ndim != axes or param.dtype.size_bytes != instr.width:
            return self._values.constant(4 * MAX_ELEMENTS // instr.width)
        size = self.function.settled(Input(f"{instr.array}.shape{axis}"))
        if isinstance(size, Const):
            return self._values.constant(size.word)
        return self._values.symbol(size)


@dataclass(frozen=True, slots=True)
class _Linear:
    """stride * (iteration index) + constant + terms, modulo 2**32."""

    stride: int
    constant: int
    terms: frozenset[tuple[Monomial, int]]


def _solved(
    first: Place,
    mine: tuple[_Linear, ...],
    second: Place,
    theirs: tuple[_Linear, ...],
    *,
    now: bool,
) -> Distances | None:
    """Of subscripts that differ by constants; None if they do not.

    In each dimension the second access in iteration t + k starts gap + k * stride bytes behind the
    first in iteration t; they share a byte iff -second.width < gap + k * stride < first.width in
    all (in all but the last, these are whole elements).
    """
    lowest, highest = -_WORDS, _WORDS
    widths = (first.instr.width, second.instr.width)
    if len(mine) > 1 and widths[0] != widths[1]:
        return None
    for one, other in zip(mine, theirs, strict=True):
        if one.stride != other.stride or one.terms != other.terms or abs(one.stride) >= _STEEP:
            return None
        window = _window(signed(other.constant - one.constant), one.stride, *widths)
        lowest, highest = max(lowest, window[0]), min(highest, window[1])
    later = max(lowest, int(not now))
    earlier = max(-highest, 1)
    return Distances(later if later <= highest else None, earlier if -earlier >= lowest else None)


def _is_word(number: int) -> bool:
    return -(_WORDS // 2) <= number < _WORDS // 2


def _is_certain(instr: Instr) -> bool:
    """Whether it is an access without a predicate."""
    return instr.op in MEMORY and len(instr.operands) == OPCODES[instr.opcode].arity + 1


def _divided(parts: tuple[Polynomial, ...], size: int) -> tuple[Polynomial, ...] | None:
    """Polynomials divided by a number that divides all coefficients; None if it does not."""
    if any(factor % size for part in parts for factor in part.terms.values()):
        return None
    return tuple(
        Polynomial({monomial: factor // size for monomial, factor in part.terms.items()})
        for part in parts
    )


def _not_from_end(part: Polynomial, function: Function) -> Polynomial:
    """A subscript without what is added to it where it is negative: the size, or 0."""
    terms = dict(part.terms)
    for monomial, factor in part.terms.items():
        item = definition_of(function, monomial[0]) if len(monomial) == 1 else None
        added = item.operands[1:] if isinstance(item, Instr) and item.op is Opcode.SELECT else ()
        if added and factor == 1 and is_length(added[0]) and added[1] == Const(0):
            del terms[monomial]
    return Polynomial(terms)


def _window(gap: int, stride: int, width: int, other: int) -> tuple[int, int]:
    """The first and last k with -other < gap + k * stride < width."""
    if not stride:
        return (-_WORDS, _WORDS) if -other < gap < width else (1, 0)
    if stride < 0:
        low, high = _window(gap, -stride, width, other)
        return -high, -low
    return (-other - gap) // stride + 1, -((gap - width) // stride) - 1


def _always(apart: isl.Set, first: isl.Set, second: isl.Set, later: int) -> bool:
    """Whether accesses `later` iterations apart meet whenever both run so, whatever the parameters
    are.
    """
    move = isl.Map.read_from_str(apart.get_ctx(), f"{{ [i] -> [i - {later}] }}")
    met = apart.fix_val(isl.dim_type.set, 0, isl.Val(later)).params()
    return bool(first.intersect(second.apply(move)).params().is_subset(met))


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


@contextmanager
def _bounded(operations: int) -> Iterator[None]:
    """isl gives up where it would take long; nothing is known then."""
    context = isl.DEFAULT_CONTEXT
    context.reset_operations()
    context.set_max_operations(operations)
    try:
        yield
    except isl.Error:  # it says at random what it was doing then
        pass
    finally:
        context.set_max_operations(0)
