"""Which loops are static-control parts, and why others are not."""

from __future__ import annotations

import pytest

from tests.ssa.support import function
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.scop import Scop, find_scop
from vividc.ssa.rewrite.refusal import Refusal

LOOP = """b0:
  jump b1
b1:
  %0 i32 = phi [b0: {first}, b3: %1]
  %2 pred = icmp.slt %0, {limit}
  branch %2 b2 else b4
b2:
{body}
  jump b3
b3:
  %1 i32 = add %0, {step}
  jump b1
b4:
{after}
"""
STORE = '  %3 none = store $"&x", %0, 0x1 array "x" shift 2'


def found(
    body: str = STORE,
    after: str = "  return",
    first: str = "0x0",
    limit: str = '$"x.shape0"',
    step: str = "0x1",
) -> Scop | str:
    """The part, or why it is none."""
    text = LOOP.format(body=body, after=after, first=first, limit=limit, step=step)
    made = find_scop(function(text), "b1")
    return made.reason if isinstance(made, Refusal) else made


def test_a_loop_over_an_array_is_a_part() -> None:
    part = found()
    assert isinstance(part, Scop)
    [statement] = part.statements
    [dim] = statement.dims
    [(name, value)] = part.symbols.items()
    assert (dim.bounds, dim.value) == ((Form(), symbol(name)), symbol("i0"))
    assert str(value) == "Input(key='x.shape0')"
    [access] = statement.accesses.values()
    assert (access.array, access.is_store, access.subscripts) == ("x", True, (symbol("i0"),))
    assert (part.entry, part.exit) == ("b0", "b4")


def test_a_loop_to_a_number_that_is_no_length_is_a_part() -> None:
    assert isinstance(found(limit='$"n"'), Scop)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (
            {"after": '  %9 none = store $"&x", 0x0, %0 array "x" shift 2\n  return'},
            "a value of it that it does not carry is read after it",
        ),
        ({"step": "0x2"}, "a loop's iterations are not counted before it starts"),
        ({"first": '$"n"'}, "a loop starts at a number that may be anything"),
    ],
    ids=["counter read after it", "step", "start"],
)
def test_why_a_loop_is_no_part(given: dict[str, str], reason: str) -> None:
    assert found(**given) == reason


MAKES = """param "n" int32
param "m" int32
param "x" int32[1]
local "t" words 0 size {size}
b0:
  %9 pred = icmp.slt $"n", {least}
  branch %9 b4 else b5
b5:
  jump b1
b1:
  %0 i32 = phi [b5: $"n", b3: %1]
  %2 pred = icmp.slt 0x0, %0
  branch %2 b2 else b4
b2:
  %3 none = store $"&x", %0, 0x1 array "x" shift 2
  jump b3
b3:
  %1 i32 = add %0, 0xffffffff
  jump b1
b4:
  return
"""


@pytest.mark.parametrize(
    ("size", "least", "is_part"),
    [
        ('"s:n" "s:n" "*" 1 "*"', "0x0", True),
        ('"s:n" "s:n" "*" 1 "*"', "0xffffffff", False),  # -1 times -1 is 1
        ('"s:n" "s:m" "*" 1 "*"', "0x0", False),  # m may be 0
        ('"s:n" 2048 "*"', "0x0", True),
        ('"s:n" 1 "*"', "0x0", False),  # up to as many words as there are
        ('"s:n" "s:n" "*" 1 "+"', "0x0", False),
    ],
)
def test_a_loop_may_start_at_what_proves_to_be_a_length(
    size: str, least: str, is_part: bool
) -> None:
    """A side of an array that the kernel makes, which is not negative, counts rows."""
    part = find_scop(function(MAKES.format(size=size, least=least)), "b1")
    assert isinstance(part, Scop) is is_part
    if isinstance(part, Scop):
        assert {str(part.symbols[name]) for name in part.lengths} == {"Input(key='n')"}
    else:
        assert part.reason == "a loop starts at a number that may be anything"


BEHIND = """b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b7: %9]
  %1 pred = icmp.slt %0, $"x.shape0"
  branch %1 b2 else b8
b2:
  jump b3
b3:
  %2 i32 = phi [b2: 0x0, b4: %5]
  %3 pred = icmp.slt %2, %0
  branch %3 b4 else b5
b4:
  %4 none = store $"&x", %2, 0x1 array "x" shift 2
  %5 i32 = add %2, 0x1 exact
  jump b3
b5:
{behind}
  jump b7
b7:
  %9 i32 = add %0, 0x1 exact
  jump b1
b8:
  return
"""


@pytest.mark.parametrize(
    ("behind", "reason"),
    [
        ('  %6 none = store $"&x", %0, 0x2 array "x" shift 2', ""),
        ('  %6 none = store $"&x", %2, 0x2 array "x" shift 2', "a counter is read behind its loop"),
        ('  %6 none = store $"&x", %0, %2 array "x" shift 2', "a counter is read behind its loop"),
    ],
    ids=["not read", "as a subscript", "as a number"],
)
def test_a_counter_means_nothing_behind_its_loop(behind: str, reason: str) -> None:
    made = find_scop(function(BEHIND.format(behind=behind)), "b1")
    assert (made.reason if isinstance(made, Refusal) else "") == reason
