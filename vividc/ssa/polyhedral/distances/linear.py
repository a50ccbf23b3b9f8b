"""Accesses whose subscripts move by constants from one iteration of a loop to the next: where they
meet is told by arithmetic, without isl.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.machine.words import signed
from vividc.ssa.analysis.polynomial import Monomial
from vividc.ssa.ir import Instr

STEEP: Final = 1 << 15
"""Words that move by less wrap after more iterations than any schedule has under way."""
WORDS: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Place:
    """An access in a block."""

    instr: Instr
    block: str

    def __hash__(self) -> int:
        return hash((self.instr.id, self.block))


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
class Linear:
    """stride * (iteration index) + constant + terms, modulo 2**32: a subscript in bytes."""

    stride: int
    constant: int
    terms: frozenset[tuple[Monomial, int]]


Subscripts = tuple[Linear, ...]


def solved(
    first: Place, mine: Subscripts, second: Place, theirs: Subscripts, *, now: bool
) -> Distances | None:
    """Of subscripts that differ by constants; None if they do not.

    In each dimension the second access in iteration t + k starts gap + k * stride bytes behind the
    first in iteration t; they share a byte iff -second.width < gap + k * stride < first.width in
    all (in all but the last, these are whole elements).
    """
    lowest, highest = -WORDS, WORDS
    widths = (first.instr.width, second.instr.width)
    if len(mine) > 1 and widths[0] != widths[1]:
        return None
    for one, other in zip(mine, theirs, strict=True):
        same = one.terms is other.terms or one.terms == other.terms  # the former takes no looks
        if not same or one.stride != other.stride or abs(one.stride) >= STEEP:
            return None
        window = _window(signed(other.constant - one.constant), one.stride, *widths)
        lowest, highest = max(lowest, window[0]), min(highest, window[1])
    later = max(lowest, int(not now))
    earlier = max(-highest, 1)
    return Distances(later if later <= highest else None, earlier if -earlier >= lowest else None)


def _window(gap: int, stride: int, width: int, other: int) -> tuple[int, int]:
    """The first and last k with -other < gap + k * stride < width."""
    if not stride:
        return (-WORDS, WORDS) if -other < gap < width else (1, 0)
    if stride < 0:
        low, high = _window(gap, -stride, width, other)
        return -high, -low
    return (-other - gap) // stride + 1, -((gap - width) // stride) - 1


@dataclass(frozen=True, slots=True)
class _Equation:
    """The sum of factors times unknowns, `moved` times the distance, and a constant is 0 modulo
    2**32.
    """

    factors: dict[object, int]
    moved: int
    constant: int

    def distances(self) -> tuple[int, ...] | None:
        """As `only_distances`, of it alone. Without unknowns, distances are small."""
        if self.factors:
            step = math.gcd(*self.factors.values(), self.moved, WORDS)
            return () if self.constant % step else None
        if not self.moved:
            return () if self.constant else None
        least, rest = divmod(-self.constant, self.moved)
        return () if rest else (least,)

    def without_unknowns(self, other: _Equation) -> _Equation | None:
        """What two equations say of the distance, if the same sum of unknowns is in both."""
        if not self.factors or self.factors.keys() != other.factors.keys():
            return None
        key = next(iter(self.factors))
        both = math.gcd(self.factors[key], other.factors[key])
        mine, theirs = other.factors[key] // both, self.factors[key] // both
        if any(mine * f != theirs * other.factors[name] for name, f in self.factors.items()):
            return None
        moved = mine * self.moved - theirs * other.moved
        constant = signed(mine * self.constant - theirs * other.constant)
        return _Equation({}, moved, constant) if abs(moved) < STEEP else None


def only_distances(mine: Subscripts, theirs: Subscripts, width: int) -> tuple[int, ...] | None:
    """After how many iterations alone the second of two accesses of so many bytes may touch what
    the first touches: at no or one distance; None: any, for all that is known.

    In each dimension both have the same subscript. It is asked whether such equations have whole
    solutions, each for itself and any two that have the same sum of unknowns (a[i, j] and a[j, i]).
    """
    equations = list(_equations(mine, theirs, width))
    pairs = itertools.combinations(equations, 2)
    joined = (made for one, other in pairs if (made := one.without_unknowns(other)) is not None)
    found: tuple[int, ...] | None = None
    for equation in itertools.chain(equations, joined):
        distances = equation.distances()
        if distances is not None and found is not None and distances != found:
            return ()
        found = distances if found is None else found
        if found == ():
            return found
    return found


def _equations(mine: Subscripts, theirs: Subscripts, width: int) -> Iterator[_Equation]:
    """One for each dimension; none if an access is to parts of elements."""
    if not (_are_whole(mine, width) and _are_whole(theirs, width)):
        return
    for one, other in zip(mine, theirs, strict=True):
        if max(abs(one.stride), abs(other.stride)) >= STEEP:
            continue
        factors: dict[object, int] = dict(one.terms)
        for monomial, factor in other.terms:
            factors[monomial] = signed(factors.get(monomial, 0) - factor)
        factors["iteration"] = one.stride - other.stride
        kept = {key: factor for key, factor in factors.items() if factor}
        yield _Equation(kept, -other.stride, signed(one.constant - other.constant))


def _are_whole(subscripts: Sequence[Linear], width: int) -> bool:
    """Whether subscripts in bytes are those of elements of a size."""
    return not any(
        one.stride % width or one.constant % width or any(factor % width for _, factor in one.terms)
        for one in subscripts
    )
