"""Long formulas made short: equal products are added up, and of a maximum stays only what may be
greatest.

A formula is read as a polynomial with integer factors; its unknowns are the inputs of a launch, and
maxima, minima and quotients of polynomials. Dimensions and `u:` inputs are not negative, so that
of x and x - 2, and of x and x + y, it is known which is greater.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from vividc.machine.params import Formula

_MOST: Final = 64
"""Terms of a polynomial that are looked at."""


@dataclass(frozen=True, slots=True)
class _Part:
    """A maximum, minimum or quotient, an unknown of a polynomial around it."""

    op: str
    of: tuple[_Sum, ...]


_Unknown = str | _Part
_Sum = tuple[tuple[tuple[_Unknown, ...], int], ...]
"""Products and their factors, in order."""


class _TooLong(Exception):
    """The formula is left as it is."""


@lru_cache(maxsize=4096)
def shortened(formula: Formula) -> Formula:
    """The same number as a formula that is not longer."""
    try:
        found = tuple(_postfix(_read(formula)))
    except _TooLong:
        return formula
    return found if len(found) < len(formula) else formula


def _read(formula: Formula) -> _Sum:
    stack: list[_Sum] = []
    for item in formula:
        if isinstance(item, int):
            stack.append(_sum([((), item)]))
        elif item == "+":
            right, left = stack.pop(), stack.pop()
            stack.append(_sum([*left, *right]))
        elif item == "*":
            right, left = stack.pop(), stack.pop()
            stack.append(_product(left, right))
        elif item in ("max", "min"):
            right, left = stack.pop(), stack.pop()
            stack.append(_extreme(item, left, right))
        elif item == "//":
            right, left = stack.pop(), stack.pop()
            stack.append(_unknown(_Part("//", (left, right))))
        else:
            stack.append(_unknown(item))
    return stack.pop()


def _unknown(one: _Unknown) -> _Sum:
    return (((one,), 1),)


def _sum(terms: Iterable[tuple[tuple[_Unknown, ...], int]]) -> _Sum:
    total: dict[tuple[_Unknown, ...], int] = {}
    for unknowns, factor in terms:
        total[unknowns] = total.get(unknowns, 0) + factor
    if len(total) > _MOST:
        raise _TooLong
    kept = (item for item in total.items() if item[1])
    return tuple(sorted(kept, key=repr))


def _product(left: _Sum, right: _Sum) -> _Sum:
    if len(left) * len(right) > _MOST:
        raise _TooLong
    return _sum((tuple(sorted((*a, *b), key=repr)), x * y) for a, x in left for b, y in right)


def _extreme(op: str, left: _Sum, right: _Sum) -> _Sum:
    """The maximum or minimum of two, of parts that it may be."""
    parts: list[_Sum] = []
    for one in (*_parts(op, left), *_parts(op, right)):
        if any(_is_beyond(op, other, one) for other in parts):
            continue
        parts = [other for other in parts if not _is_beyond(op, one, other)]
        parts.append(one)
    if len(parts) == 1:
        return parts[0]
    return _unknown(_Part(op, tuple(sorted(parts, key=repr))))


def _parts(op: str, whole: _Sum) -> tuple[_Sum, ...]:
    if len(whole) == 1 and whole[0][1] == 1 and len(whole[0][0]) == 1:
        part = whole[0][0][0]
        if isinstance(part, _Part) and part.op == op:
            return part.of
    return (whole,)


def _is_beyond(op: str, one: _Sum, other: _Sum) -> bool:
    """Whether `one` is never less than `other`, or of a minimum never more."""
    return _is_most(one, other) if op == "max" else _is_most(other, one)


def _is_most(one: _Sum, other: _Sum) -> bool:
    """Whether `one` is known never to be less than `other`."""
    less = [(unknowns, -factor) for unknowns, factor in other]
    if _is_natural_sum(_sum([*one, *less])):
        return True
    if len(theirs := _parts("max", other)) > 1:
        return all(_is_most(one, part) for part in theirs)
    if len(mine := _parts("min", one)) > 1:
        return all(_is_most(part, other) for part in mine)
    if len(mine := _parts("max", one)) > 1 and any(_is_most(part, other) for part in mine):
        return True
    theirs = _parts("min", other)
    return len(theirs) > 1 and any(_is_most(one, part) for part in theirs)


def _is_natural(one: _Unknown) -> bool:
    """Whether an unknown is never negative."""
    if isinstance(one, str):
        return one.startswith("u:") or ".shape" in one
    naturals = [_is_natural_sum(part) for part in one.of]
    return any(naturals) if one.op == "max" else all(naturals)


def _is_natural_sum(one: _Sum) -> bool:
    return all(factor > 0 and all(map(_is_natural, unknowns)) for unknowns, factor in one)


def _postfix(whole: _Sum) -> Iterator[str | int]:
    if not whole:
        yield 0
    for number, (unknowns, factor) in enumerate(whole):
        for at, unknown in enumerate(unknowns):
            yield from _unknown_postfix(unknown)
            if at:
                yield "*"
        if factor != 1 or not unknowns:
            yield factor
            if unknowns:
                yield "*"
        if number:
            yield "+"


def _unknown_postfix(one: _Unknown) -> Iterator[str | int]:
    if isinstance(one, str):
        yield one
        return
    for number, part in enumerate(one.of):
        yield from _postfix(part)
        if number:
            yield one.op
