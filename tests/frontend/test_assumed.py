"""Bounds of what an iteration hands on, by induction: checked against values."""

from __future__ import annotations

from itertools import product

import pytest

from vividc.frontend.ranges.assumed import assumed, no_more
from vividc.machine.params import Formula, evaluate_formula

H = assumed(7)
KNOWN: list[tuple[Formula, bool]] = [
    ((H,), True),
    ((0, H, 0, "max", 1, "*", "+"), True),
    ((H, "s:n", "max"), True),
    ((H, "s:n", "min"), True),
    ((H, -1, "+"), True),
    ((H, 2, "//"), True),
    ((H, "s:n", "max", 3, "//"), True),
    (("s:n", 1, "+"), True),
    ((H, 1, "+"), False),
    ((H, 2, "*"), False),
    ((H, -1, "*"), False),
    ((H, "s:n", "+"), False),
    ((H, "s:n", "//"), False),
    ((H, 1, "+", "s:n", "max"), False),
]


@pytest.mark.parametrize(("formula", "is_known"), KNOWN)
def test_a_number_is_no_more_than_what_is_assumed_or_the_rest(
    formula: Formula, is_known: bool
) -> None:
    rest = no_more(formula, H)
    assert (rest is not None) == is_known
    for n, h in product(range(-6, 7), range(-6, 7)):
        inputs = {"n": n & 0xFFFFFFFF, H[2:]: h & 0xFFFFFFFF}
        if rest is not None:
            most = max([h, *([evaluate_formula(rest, inputs)] if rest else [])])
            assert evaluate_formula(formula, inputs) <= most
