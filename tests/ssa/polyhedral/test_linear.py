"""Where accesses meet, told by arithmetic: no meeting is overlooked."""

from __future__ import annotations

import itertools
import random

import pytest

from vividc.ssa.ir import Input
from vividc.ssa.polyhedral.distances.linear import Linear, only_distances

WORD = 4
ROW, N = (Input("0"),), (Input("1"),)


def at(stride: int, constant: int, **factors: int) -> Linear:
    """A subscript in elements of a word."""
    names = {"i": ROW, "n": N}
    terms = frozenset((names[name], WORD * factor) for name, factor in factors.items())
    return Linear(WORD * stride, WORD * constant, terms)


@pytest.mark.parametrize(
    ("mine", "theirs", "expected"),
    [
        # a[i, j] and a[j + 1, i + 1], j moving by 4: i - j is both 1 and -1
        ((at(0, 0, i=1), at(4, 0)), (at(4, 1), at(0, 1, i=1)), ()),
        # a[i, j + 3] and a[j, i + 1]: one group later
        ((at(0, 0, i=1), at(4, 3)), (at(4, 0), at(0, -1, i=1)), (1,)),
        # rows i and i + 1
        ((at(0, 0, i=1), at(4, 0)), (at(0, 1, i=1), at(4, 0)), ()),
        # row n and row i, columns of another member of a group
        ((at(0, 0, n=1), at(4, 1)), (at(0, 0, i=1), at(4, 3)), ()),
        ((at(0, 0, n=1), at(4, 1)), (at(0, 0, i=1), at(4, 1)), (0,)),
        # even and odd elements, at different speeds
        ((at(2, 0),), (at(4, 1),), ()),
        ((at(2, 0),), (at(4, 2),), None),
        ((at(2, 0, i=6),), (at(4, 3, n=2),), ()),
        # a[i, j] and a[j, n]
        ((at(0, 0, i=1), at(1, 0)), (at(1, 0), at(0, 0, n=1)), None),
    ],
)
def test_only_distances(
    mine: tuple[Linear, ...], theirs: tuple[Linear, ...], expected: tuple[int, ...] | None
) -> None:
    assert only_distances(mine, theirs, WORD) == expected


def test_parts_of_elements_may_meet_anywhere() -> None:
    half = Linear(WORD, 2, frozenset())
    assert only_distances((half,), (Linear(WORD, 0, frozenset()),), WORD) is None


def test_every_meeting_is_at_a_distance_that_is_left() -> None:
    draw = random.Random(3)

    def subscript() -> Linear:
        return at(draw.randint(-2, 2), draw.randint(-3, 3), i=draw.randint(-2, 2))

    def value(one: Linear, iteration: int, i: int) -> int:
        return one.stride * iteration + one.constant + sum(f * i for _, f in one.terms)

    ruled_out = 0
    for _ in range(300):
        mine, theirs = (tuple(subscript() for _ in range(2)) for _ in range(2))
        left = only_distances(mine, theirs, WORD)
        ruled_out += left is not None
        for k, t, i in itertools.product(range(-4, 5), range(3), range(-2, 3)):
            one = [value(part, t, i) for part in mine]
            if left is not None and one == [value(part, t + k, i) for part in theirs]:
                assert k in left
    assert ruled_out > 30
