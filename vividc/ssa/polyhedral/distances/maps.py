"""Accesses as isl's maps from iterations to the elements that they are to."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import islpy as isl

from vividc.machine.opcodes import MEMORY, OPCODES
from vividc.machine.params import MAX_ELEMENTS
from vividc.ssa.analysis.polynomial import Monomial, Polynomial, constant
from vividc.ssa.ir import Const, Function, Input, Instr
from vividc.ssa.polyhedral.distances.linear import WORDS, Place
from vividc.ssa.polyhedral.values import Expression, Expressions


@dataclass
class Maps:
    """Maps of the accesses of one loop, or of one run of a block, by `subscripts`. A subscript that
    many accesses have, and when a block runs, are looked at once.
    """

    function: Function
    values: Expressions
    subscripts: Callable[[Instr], tuple[Polynomial, ...] | None]
    _exact: dict[Place, isl.Map | None] = field(init=False, default_factory=dict)
    _inside: dict[Hashable, tuple[isl.Map, isl.Set] | None] = field(
        init=False, default_factory=dict
    )
    _running: dict[Hashable, isl.Set] = field(init=False, default_factory=dict)

    def of(self, place: Place) -> isl.Map | None:
        """From iterations to the element that the access is to, by its subscripts; None if it is to
        parts of elements.
        """
        if place not in self._exact:
            self._exact[place] = None
            instr = place.instr
            parts = self.subscripts(instr)
            words = WORDS
            if parts is not None and (instr.width != 1 << instr.shift or instr.offset):
                parts = _divided(in_bytes(parts, instr), instr.width)
                words //= instr.width
            if parts is not None:
                self._exact[place] = self._subscript_map(place, parts, words)
        return self._exact[place]

    def _subscript_map(
        self, place: Place, parts: tuple[Polynomial, ...], words: int
    ) -> isl.Map | None:
        """Of subscripts that are known modulo `words`."""
        known = [
            self._subscript(place.instr, axis, part, len(parts), words)
            for axis, part in enumerate(parts)
        ]
        found: isl.Map | None = None
        inside: list[isl.Set] = []
        for one in known:
            if one is None:
                return None
            found = one[0] if found is None else found.flat_range_product(one[0])
            inside.append(one[1])
        return None if found is None else found.intersect_domain(self._running_at(place, inside))

    def _subscript(
        self, instr: Instr, axis: int, part: Polynomial, axes: int, words: int
    ) -> tuple[isl.Map, isl.Set] | None:
        """A subscript in each iteration, and the iterations in which it is in its dimension."""
        key = (instr.array, instr.width, axis, axes, words, frozenset(part.terms.items()))
        if key not in self._inside:
            self._inside[key] = None
            try:
                self._inside[key] = self._subscript_of(instr, axis, part, axes, words)
            except isl.Error:  # out of operations, which says nothing about it
                del self._inside[key]
                raise
        return self._inside[key]

    def _subscript_of(
        self, instr: Instr, axis: int, part: Polynomial, axes: int, words: int
    ) -> tuple[isl.Map, isl.Set] | None:
        subscript = self._sum(part)
        if subscript is None:
            return None
        extent = self._extent(instr, axis, axes)
        if subscript.low < extent.high - words or subscript.high >= words:
            subscript = subscript.modulo(words)  # else one in its bounds is the sum itself
        inside = subscript.aff.ge_set(self.values.constant(0).aff)
        inside = inside.intersect(subscript.aff.lt_set(extent.aff))
        return isl.Map.from_pw_aff(subscript.aff), inside

    def _running_at(self, place: Place, inside: list[isl.Set]) -> isl.Set:
        """Iterations in which an access may be made, with what is known of the parameters."""
        predicate = None if is_certain(place.instr) else place.instr.operands[-1]
        key: tuple[Hashable, ...] = (place.block, predicate, self.values.met)
        if key not in self._running:
            self._running[key] = self._runs(place)
        for one in inside:  # each is kept in `_inside`
            within = (*key, id(one))
            if within not in self._running:
                self._running[within] = self._running[key].intersect(one)
            key = within
        return self._running[key]

    def _runs(self, place: Place) -> isl.Set:
        """Iterations in which an access may be made: its predicate says so, too."""
        domain = self.values.domain(place.block)
        if is_certain(place.instr):
            return domain
        held = self.values.holds(place.instr.operands[-1], True)
        return domain if held is None else domain.intersect(held).intersect(self.values.universe)

    def _sum(self, part: Polynomial) -> Expression | None:
        total = self.values.constant(0)
        for monomial, factor in part.terms.items():
            value = self._product(monomial)
            if value is None:
                return None
            total = total.plus(value, factor)
        return total

    def _product(self, monomial: Monomial) -> Expression | None:
        if not monomial:
            return self.values.constant(1)
        if len(monomial) == 1:
            return self.values.of(monomial[0])
        fixed = all(self.values.is_fixed(value) for value in monomial)
        return self.values.symbol(monomial) if fixed else None

    def _extent(self, instr: Instr, axis: int, axes: int) -> Expression:
        """What a subscript is less than."""
        param = next((p for p in self.function.params if p.name == instr.array), None)
        if param is None or param.ndim != axes or param.dtype.size_bytes != instr.width:
            return self.values.constant(4 * MAX_ELEMENTS // instr.width)
        size = self.function.settled(Input(f"{instr.array}.shape{axis}"))
        if isinstance(size, Const):
            return self.values.constant(size.word)
        return self.values.symbol(size)


def in_bytes(subscripts: tuple[Polynomial, ...], access: Instr) -> tuple[Polynomial, ...]:
    """Subscripts times the bytes from one index to the next; the last with the offset."""
    *outer, last = (part.times(constant(1 << access.shift)) for part in subscripts)
    return (*outer, last.plus(constant(access.offset)))


def is_certain(instr: Instr) -> bool:
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
