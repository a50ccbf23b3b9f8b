"""Forms as numbers: sums, products and comparisons mean what they are written as."""

from __future__ import annotations

import itertools
import operator
import random

import pytest

from vividc.machine.opcodes import Opcode
from vividc.ssa.polyhedral.forms import COMPARISONS, Form, compared, form, symbol, zeros

X, Y = symbol("x"), symbol("y")
NUMBERS = range(-3, 4)
HOLDS = {
    Opcode.ICMP_SLT: operator.lt,
    Opcode.ICMP_SLE: operator.le,
    Opcode.ICMP_EQ: operator.eq,
}


def number(of: Form, **values: int) -> int:
    return sum(factor * values[name] for name, factor in of.terms) + of.constant


@pytest.mark.parametrize("holds", [True, False])
@pytest.mark.parametrize("op", COMPARISONS, ids=lambda op: op.value)
def test_forms_are_not_negative_where_a_comparison_holds(op: Opcode, holds: bool) -> None:
    left, right = X.times(2).plus(Form((), 1)), Y
    found = compared(op, left, right, holds)
    if op is Opcode.ICMP_EQ and not holds:
        assert found == ()
        return
    assert found
    for x, y in itertools.product(NUMBERS, repeat=2):
        wanted = HOLDS[op](2 * x + 1, y) is holds
        assert all(number(one, x=x, y=y) >= 0 for one in found) is wanted


def test_sums_and_products_of_forms() -> None:
    one, other = form({"x": 2, "y": -1}, 3), form({"x": -2, "z": 5}, 1)
    assert one.plus(other) == form({"y": -1, "z": 5}, 4)
    assert one.plus(other, -2) == form({"x": 6, "y": -1, "z": -10}, 1)
    assert one.times(-1) == form({"x": -2, "y": 1}, -3)
    assert form({"x": 4, "y": -6}, 2).divided(2) == form({"x": 2, "y": -3}, 1)
    assert form({"x": 4, "y": -6}, 3).divided(2) is None
    assert form({"x": 4, "y": -5}, 2).divided(2) is None
    assert (one.names, form({"x": 0}).names) == ({"x", "y"}, set())


def test_forms_in_place_of_names() -> None:
    given = {"x": Y.plus(Form((), 1)), "y": X}
    assert form({"x": 2, "y": -1, "z": 1}, 3).substituted(given) == form(
        {"x": -1, "y": 2, "z": 1}, 5
    )


def test_isl_reads_what_is_printed() -> None:
    assert str(form({"y": -1, "x": 2}, -3)) == "2*x + -1*y + (-3)"
    assert str(Form()) == "(0)"


def test_zeros_have_the_solutions_of_the_forms_that_they_are_made_of() -> None:
    chance, range_ = random.Random(3), range(-4, 5)
    kept = 0
    for _ in range(150):
        forms = [
            form({n: chance.randint(-3, 3) for n in "xyz"}, chance.randint(-3, 3))
            for _ in range(chance.randint(1, 3))
        ]
        found = zeros(forms)
        kept += found is not None
        for x, y, z in itertools.product(range_, repeat=3):
            at = {"x": x, "y": y, "z": z}
            wanted = all(number(one, **at) == 0 for one in forms)
            same = found is not None and all(number(one, **at) == 0 for one in found.forms)
            assert same is wanted, forms
            if wanted and found is not None:
                assert all(number(value, **at) == at[n] for n, value in found.solved.items())
    assert 20 < kept < 140


def test_zeros_see_what_contradicts_itself() -> None:
    one = Form((), 1)
    assert zeros([X.plus(Y, -1), Y.plus(X, -1).plus(one)]) is None
    assert zeros([X.times(4).plus(Y, 2).plus(one)]) is None
    same = zeros([X.plus(Y, -1), Y.plus(X, -1)])
    assert same is not None
    assert len(same.forms) == 1
