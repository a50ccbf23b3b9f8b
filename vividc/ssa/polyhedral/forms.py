"""Integer forms: constants times names, plus a constant; what subscripts and bounds are made of."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.host.once import made_soon
from vividc.machine.opcodes import Opcode

COMPARISONS: Final = (Opcode.ICMP_SLT, Opcode.ICMP_SLE, Opcode.ICMP_EQ)


@made_soon
@dataclass(frozen=True, slots=True)
class Form:
    """Sum of factor * name over `terms` (sorted by name, no factor is 0), plus `constant`."""

    terms: tuple[tuple[str, int], ...] = ()
    constant: int = 0

    def plus(self, other: Form, factor: int = 1) -> Form:
        """self + factor * other."""
        constant = self.constant + factor * other.constant
        if not other.terms:
            return Form(self.terms, constant)
        terms = dict(self.terms)
        for name, count in other.terms:
            terms[name] = terms.get(name, 0) + factor * count
        return form(terms, constant)

    def times(self, factor: int) -> Form:
        """factor * self."""
        return Form().plus(self, factor)

    def divided(self, divisor: int) -> Form | None:
        """The form of which this is `divisor` times; None if there is none."""
        if self.constant % divisor or any(factor % divisor for _, factor in self.terms):
            return None
        terms = tuple((name, factor // divisor) for name, factor in self.terms)
        return Form(terms, self.constant // divisor)

    def substituted(self, values: Mapping[str, Form]) -> Form:
        """The form with forms in place of names."""
        terms: dict[str, int] = {}
        constant = self.constant
        for name, factor in self.terms:
            value = values.get(name)
            if value is None:
                terms[name] = terms.get(name, 0) + factor
                continue
            constant += factor * value.constant
            for inner, count in value.terms:
                terms[inner] = terms.get(inner, 0) + factor * count
        return form(terms, constant)

    @property
    def names(self) -> frozenset[str]:
        """The names that occur."""
        return frozenset(name for name, _ in self.terms)

    def __str__(self) -> str:
        """As isl reads it."""
        parts = [f"{factor}*{name}" for name, factor in self.terms]
        return " + ".join((*parts, f"({self.constant})"))


def form(terms: Mapping[str, int], constant: int = 0) -> Form:
    """The form with these factors by name."""
    return Form(tuple(sorted((n, f) for n, f in terms.items() if f)), constant)


def symbol(name: str) -> Form:
    """The form of one name."""
    return Form(((name, 1),))


ZERO = Form()
"""The form of 0."""


@dataclass(frozen=True, slots=True)
class Zeros:
    """Forms that are 0 together, none of which follows from the others by adding and subtracting.

    Attributes
    ----------
    forms
        Sorted, so that systems that are seen to have the same solutions are equal.
    solved
        Names by others, where a form has a name once: no value has one of these names.
    """

    forms: tuple[Form, ...]
    solved: Mapping[str, Form]


def zeros(forms: Iterable[Form]) -> Zeros | None:
    """Integers at which all forms are 0 are those of this system, and the other way round; None if
    there are none, as elimination or a common divisor of the factors shows.
    """
    rows: list[Form] = []
    solved: dict[str, Form] = {}
    for one in forms:
        row = one.substituted(solved)
        divisor = math.gcd(*(factor for _, factor in row.terms))
        if not divisor:
            if row.constant:
                return None
            continue
        divided = row.divided(divisor)
        if divided is None:
            return None
        unit = next(((n, f) for n, f in divided.terms if abs(f) == 1), None)
        if unit is None:
            rows.append(divided if divided.terms[0][1] > 0 else divided.times(-1))
            continue
        name, factor = unit
        value = symbol(name).plus(divided, -factor)
        at = {name: value}
        solved = {n: v.substituted(at) for n, v in solved.items()} | at
    rows = [row.substituted(solved) for row in rows]
    rows += [symbol(name).plus(value, -1) for name, value in solved.items()]
    return Zeros(tuple(sorted(rows, key=_order)), solved)


def _order(one: Form) -> tuple[tuple[tuple[str, int], ...], int]:
    return one.terms, one.constant


def compared(op: Opcode, left: Form, right: Form, holds: bool) -> tuple[Form, ...]:
    """Forms that are at least 0 where one of `COMPARISONS` holds, or does not; none where two
    numbers differ, which no such forms tell.
    """
    gap = right.plus(left, -1)
    if op is Opcode.ICMP_EQ:
        return (gap, gap.times(-1)) if holds else ()
    least = Form((), int((op is Opcode.ICMP_SLT) == holds))
    return ((gap if holds else gap.times(-1)).plus(least, -1),)
