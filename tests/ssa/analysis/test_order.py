"""Which of two integers is greater: proved, left open, or what inputs would have to be."""

from __future__ import annotations

import pytest

from tests.ssa.support import function
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.ir import Const, Input, Ref, Value

NEST = """param "a" int32[2]
param "b" int32[1]
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b5: %1]
  %2 pred = icmp.slt %0, $"a.shape0"
  %1 i32 = add %0, 0x1 exact
  branch %2 b2 else b6
b2:
  %3 i32 = smin %1, $"a.shape0"
  %10 i32 = smin %1, $"b.shape0"
  %11 pred = icmp.ult %0, $"b.shape0"
  %12 i32 = select %11, %0, $"b.shape0"
  %13 i32 = add %0, %0
  jump b3
b3:
  %4 i32 = phi [b2: 0x2, b4: %5]
  %6 pred = icmp.slt %4, %3
  branch %6 b4 else b5
b4:
  %5 i32 = add %4, 0x1 exact
  %7 i32 = load $"&b", %4 array "b" shift 2
  jump b3
b5:
  jump b1
b6:
  return
"""
ROW, COLUMN, ROWS, ITEMS = Ref(0), Ref(4), Input("a.shape0"), Input("b.shape0")
FIT = Sum(((ROWS, -1), (ITEMS, 1)))


@pytest.mark.parametrize(
    ("less", "more", "block"),
    [
        (Ref(1), ROWS, "b2"),
        (Const(0), ROW, "b6"),
        (Const(2), COLUMN, "b3"),
        (COLUMN, ROW, "b4"),
        (Ref(5), Ref(1), "b4"),
        (Ref(3), Ref(1), "b2"),
        (Ref(1), Ref(3), "b2"),
        (Ref(12), ROW, "b2"),
        (Ref(12), ITEMS, "b2"),
        (Const(0), Ref(12), "b2"),
    ],
)
def test_it_is_proved(less: Value, more: Value, block: str) -> None:
    assert Order(function(NEST)).at_most(less, more, block) == ()


@pytest.mark.parametrize(
    ("less", "more", "block"),
    [
        (ROW, COLUMN, "b4"),
        (Ref(1), ROWS, "b1"),  # behind the last iteration
        (Ref(1), ROW, "b2"),
        (Ref(7), ROWS, "b4"),  # it is loaded behind
        (Const(0), Ref(13), "b2"),  # it may wrap
        (Ref(1), ITEMS, "b2"),
        (ROWS, ROW, "b2"),
    ],
)
def test_it_is_left_open(less: Value, more: Value, block: str) -> None:
    assert Order(function(NEST)).at_most(less, more, block) is None


@pytest.mark.parametrize(("less", "more"), [(Ref(1), ITEMS), (Ref(3), Ref(10)), (ROW, Ref(12))])
def test_what_is_lacking_is_told(less: Value, more: Value) -> None:
    assert Order(function(NEST), may_lack=True).at_most(less, more, "b2") == (FIT,)


def test_what_is_given_is_used() -> None:
    order = Order(function(NEST), given=[FIT])
    assert order.at_most(Ref(1), ITEMS, "b2") == ()


def test_small_sizes_are_not_asked_for() -> None:
    """No proof takes it that an array has one element."""
    order = Order(function(NEST), may_lack=True)
    assert order.at_most(ITEMS, Const(1), "b2") is None
    assert order.at_most(ROWS, ROW, "b2") is None
    assert order.at_most(Const(1), ITEMS, "b2") == (Sum(((ITEMS, 1),), -1),)


BRANCHES = """param "n" int32
param "m" int32
b0:
  %0 pred = icmp.slt $"n", $"m"
  %1 pred = icmp.sle $"m", 0x9
  %2 pred = and %0, %1
  %3 pred = icmp.ult $"n", $"m"
  branch %2 b1 else b2
b1:
  %4 pred = icmp.slt $"n", 0x9
  %5 pred = icmp.eq $"n", $"m"
  %6 pred = icmp.ne $"n", $"m"
  return
b2:
  return
"""


@pytest.mark.parametrize(
    ("test", "block", "truth"),
    [
        (4, "b1", True),
        (5, "b1", False),
        (6, "b1", True),
        (0, "b1", True),
        (2, "b1", True),
        (0, "b2", None),
        (3, "b1", None),  # n may be negative
    ],
)
def test_branches_are_known(test: int, block: str, truth: bool | None) -> None:
    assert Order(function(BRANCHES)).truth(Ref(test), block) is truth


SELECTED = """param "b" int32[1]
b0:
  %0 i32 = load $"&b", 0x0 array "b" shift 2
  %1 i32 = load $"&b", 0x1 array "b" shift 2
  %2 pred = icmp.ult %0, %1
  %3 i32 = select %2, %0, %1
  %4 pred = icmp.sle %3, %0
  branch %4 b1 else b2
b1:
  jump b2
b2:
  return
"""


def test_a_selection_whose_test_asks_for_itself_is_left_open() -> None:
    """Whether a word is natural follows from a selection, whose test has no sign if it is."""
    order = Order(function(SELECTED))
    assert order.at_most(Const(0), Ref(0), "b1") is None
