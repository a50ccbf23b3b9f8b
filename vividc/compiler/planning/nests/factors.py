"""Factors: how many iterations of a loop, or of a loop and one inside it, run together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product

from vividc.ssa.polyhedral.orders.search import Path, loops_in
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop

FACTORS = ((4, 4), (4,))
OF_SKEWED = (2, 4)
LARGER = {
    (2, 4): ((2, 6), (2, 8), (4, 4)),
    (4, 4): ((5, 5), (8, 4), (4, 8)),
    (1, 4): ((1, 8),),
    (4, 1): ((8, 1),),
    (8, 4): ((8, 5),),
    (12, 1): ((16, 1),),
    (4, 8): ((5, 8),),
    (1, 12): ((1, 16),),
    (4,): ((8,),),
    (8,): ((16,),),
}
OF_WAITING: Mapping[tuple[int, ...], tuple[tuple[int, ...], ...]] = {
    (8, 1): ((12, 1),),
    (1, 8): ((1, 12),),
}
"""Where a recurrence leaves half of the slots of the hottest loop (deriche: 8 rows with an II of 8
are 56 operations).
"""

SMALLER = {(4, 4): ((1, 4), (4, 1), (2, 2)), (4,): ((2,),)}
PAYS = 2.0
"""Factors that are tried of a loop and one inside it (or in a tree with skews, where what all
iterations of a group run together is short), and of one loop; then larger ones of those
that are faster than none, and smaller ones of those that are not so many times as fast. A PE array
of 4x4 has no use for more than 40 accumulators (8 by 5 of gemm: 59 operations with an II of 4).
Other orders of the source's loops are not looked at where one with a sum's loop outermost is so
many times as fast as the source's own.
"""

_LARGEST = 16
_MOST_TOGETHER = 50
"""Of factors that fill loops of known lengths, which leave no rest: each, and their product.
"""

_MOST_FILLING = 5
"""So many of those are tried: the ones with the largest products."""

_LARGE_TILE = 32
_MUCH_BETTER = 0.9
"""See `crowded`."""

_PAST = 1.05
"""See `are_past_the_best`: of 42 groups (of 234 kernels and NPBench) in which 4 by 4 and smaller
factors were tried, larger ones are the best in 10, in none where 4 by 4 takes 1.01 times the cycles
of smaller ones; at 1.05 and more (13 groups) larger ones take 1.02 times the best or more.
"""

FIRST = (((4, 4), 8), ((1, 8), 4), ((2, 2), 2))
"""What orders are compared by: the first of these whose code fits into the contexts, of two loops
and of one.
"""


def are_masks_felt(tree: Loop, loop: Loop, scop: Scop) -> bool:
    """Whether loops in a masked one, whose iterations run one after the other, differ in their
    bounds from one iteration of it to the next, access elements that the next one does, or could
    carry elements from one of their iterations to the next, which they cannot under a mask.
    """
    single = [one for _, one in loops_in(tree) if one.factor == 1]
    for statement in scop.statements:
        own = loop.over.get(statement.name)
        inner = {one.over.get(statement.name) for one in single}
        dims = (dim for dim in statement.dims if dim.name in inner)
        if any(own in bound.names for dim in dims for bound in dim.bounds):
            return True
        places = {(one.array, one.subscripts) for one in statement.accesses.values()}
        if any(own in form.names and form.names & inner for _, at in places for form in at):
            return True
        steps = {(array, tuple(form.terms for form in forms)) for array, forms in places}
        if own is not None and len(steps) < len(places):
            return True
    return False


def filling(lengths: list[int | None]) -> list[tuple[int, ...]]:
    """Factors that divide lengths, if all of these are known."""
    known = [length for length in lengths if length is not None]
    if len(known) < len(lengths):
        return []
    dividing = ([f for f in range(1, _LARGEST + 1) if n % f == 0] for n in known)
    found = [one for one in product(*dividing) if 1 < math.prod(one) <= _MOST_TOGETHER]
    return sorted(found, key=lambda one: (-math.prod(one), max(one)))[:_MOST_FILLING]


def more(cycles: Mapping[tuple[int, ...], float], first: tuple[int, ...]) -> list[tuple[int, ...]]:
    """What is tried when nothing else is left: smaller factors than the `first` ones, where larger
    ones than these are not possible (of one of the loops they may be yet), then the factor of a
    loop half-way from the best one to the next larger one that is not possible: five rows may be
    where eight are not.

    Parameters
    ----------
    cycles
        Of the factors that were tried; infinite: it is not possible.
    """
    best = min(cycles, key=lambda one: cycles[one])
    failed = [one for one, taken in cycles.items() if taken == math.inf]
    smaller = [
        one
        for one in SMALLER.get(first, ())
        if one not in cycles and not any(covers(one, less) for less in failed)
    ]
    if failed and best == first and smaller:
        return smaller
    above = min((one for one in failed if one > best), default=best)
    between = tuple((low + high) // 2 for low, high in zip(best, above, strict=True))
    is_tried = between in cycles or any(covers(between, less) for less in failed)
    return [] if len(best) > 1 or is_tried else [between]


def crowded(cycles: Mapping[tuple[int, ...], float]) -> list[tuple[int, ...]]:
    """The factors of more iterations together than most tiles have, unless they are so much better
    than the others: what they leave over at edges, and straight code, is larger (covariance of 28
    columns takes 4,727 cycles by 8 and 5 at an estimate of 0.92, gemm 2,770 instead of 3,271).
    """
    large = [one for one in cycles if math.prod(one) > _LARGE_TILE]
    rest = min((cycles[one] for one in cycles if one not in large), default=math.inf)
    return [one for one in large if cycles[one] > _MUCH_BETTER * rest]


def are_past_the_best(cycles: Mapping[tuple[int, ...], float], factors: tuple[int, ...]) -> bool:
    """Whether smaller factors are so much better than these that larger ones are not tried.

    Parameters
    ----------
    cycles
        Of the factors that were tried.
    """
    smaller = [taken for one, taken in cycles.items() if covers(factors, one)]
    return bool(smaller) and cycles.get(factors, 0.0) > _PAST * min(smaller)


def chosen(
    jammed: list[tuple[Path, ...]], pair: tuple[int, int], single: int
) -> Iterator[tuple[Path, int]]:
    """Factors of loops that are jammed two at a time, and one."""
    for group in jammed:
        factors = pair if len(group) > 1 else (single,)
        yield from ((path, f) for path, f in zip(group, factors, strict=True) if f > 1)


def of_group(group: tuple[Path, ...], factors: tuple[int, ...]) -> dict[Path, int]:
    """The factors of a group's loops that are not 1."""
    return {path: f for path, f in zip(group, factors, strict=True) if f > 1}


def covers(factors: tuple[int, ...], less: tuple[int, ...]) -> bool:
    """Whether none of the factors is smaller than its counterpart."""
    return all(f >= g for f, g in zip(factors, less, strict=True))
