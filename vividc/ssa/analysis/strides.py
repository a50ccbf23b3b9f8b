"""Subscripts that move by the same number in each iteration, one that the launch gives: `x[n * i]`.

In words such subscripts wrap. If the access is made in every iteration, each is within its array,
so that two that follow one another are less than 2**31 apart: they move by the number itself, and
all of a run are different if that is not 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, Polynomial
from vividc.ssa.ir import Value


@dataclass(frozen=True, slots=True)
class Stride:
    """A subscript is `rest` + `sign` * `by` * (the number of the iteration), `by` a fixed value."""

    by: Value
    sign: int
    rest: Polynomial

    @property
    def never_wraps(self) -> bool:
        """Whether it is not negative as long as `by` is not, so that none counts from the end."""
        first = self.rest.constant
        return self.sign > 0 and first is not None and first >= 0


def stride_of(
    part: Polynomial, forms: LoopPolynomials, is_fixed: Callable[[Value], bool]
) -> Stride | None:
    """A subscript as such; None if it moves by a constant, or by more than one value."""
    moves, rest = Polynomial({}), Polynomial({})
    for monomial, factor in part.terms.items():
        own = Polynomial({tuple(v for v in monomial if is_fixed(v)): factor})
        moving = [value for value in monomial if not is_fixed(value)]
        if not moving:
            rest = rest.plus(own)
            continue
        form = forms.of(moving[0]) if len(moving) == 1 else None
        if form is None:
            return None
        moves = moves.plus(own, form.coefficient(ITERATION))
        rest = rest.plus(own.times(form.without(ITERATION)))
    [*terms] = moves.terms.items()
    if len(terms) != 1 or len(terms[0][0]) != 1 or abs(terms[0][1]) != 1:
        return None
    [((by,), sign)] = terms
    return Stride(by, sign, rest)


def different_elements(one: tuple[int | None, ...], other: tuple[int | None, ...]) -> bool:
    """Whether subscripts of one array differ in some dimension, whatever those unknown are.

    A subscript outside its dimension is undefined: `a[i, 1]` and `a[j, 2]` never meet, although
    rows of one column would put them at one address.
    """
    for mine, theirs in zip(one, other, strict=False):
        if mine != theirs and mine is not None and theirs is not None:
            return True
    return False
