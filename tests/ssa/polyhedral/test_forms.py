"""Forms as numbers: sums, products and comparisons mean what they are written as."""

from __future__ import annotations

import itertools
import operator

import pytest

from vividc.machine.opcodes import Opcode
from vividc.ssa.polyhedral.forms import COMPARISONS, Form, compared, form, symbol

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
