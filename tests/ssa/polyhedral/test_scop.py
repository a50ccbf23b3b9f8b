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
