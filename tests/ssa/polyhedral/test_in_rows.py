"""Straight code that accesses a kernel's own arrays by flat indices: elements of different rows and
columns are different ones where the columns prove to be in their rows.
"""

from __future__ import annotations

import itertools

import pytest

from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.distances.linear import Distances, Place
from vividc.ssa.polyhedral.distances.meetings import Meetings

APART = Distances()
ROWS = """param "a" int32[2]
local "t" words 0 size "u:a.shape0" "u:a.shape1" "*" 1 "*"
b0:
  %0 i32 = mul $"i", $"a.shape1"
  %1 i32 = add %0, $"a.shape1"
  %2 i32 = add %0, $"j"
  %3 i32 = add %1, $"j"
  %4 i32 = sub $"a.shape1", $"j" exact
  %5 pred = icmp.sle 0x0, $"j"
  branch %5 b1 else b3
b1:
  %6 pred = icmp.slt $"j", $"a.shape1"
  branch %6 b2 else b3
b2:
  %7 pred = icmp.slt 0x2, %4
  %8 none = store $"&t", %2, 0x1, {predicate} array "t" shift 2 offset {offset}
  %9 none = store $"&t", %3, 0x2 array "t" shift 2
  return
b3:
  return
"""


def places(made: Function) -> list[Place]:
    return [
        Place(one, block.name)
        for block in made.blocks
        for one in block.instrs
        if one.op is Opcode.STORE
    ]


@pytest.mark.parametrize(
    ("predicate", "offset", "is_apart"),
    [("%7", 8, True), ("%7", 12, False), ("%6", 0, True), ("%6", 8, False), ("%7", -4, False)],
    ids=["in its row", "may be behind it", "the same column", "by no predicate", "before it"],
)
def test_rows_that_follow_one_another(predicate: str, offset: int, is_apart: bool) -> None:
    made = function(ROWS.format(predicate=predicate, offset=offset))
    found = Meetings(made).between(*places(made), now=True)
    assert (found == APART) == is_apart


FEW = 16
"""Stores to a row, and as many to a column: more pairs than isl is asked about."""


def test_arithmetic_tells_of_any_number_of_pairs() -> None:
    """a[i + 2 * k, j] and a[j + 2 * m + 1, i]."""
    lines = ["b0:"]
    idents = itertools.count()
    for first, other, odd in (("i", "j", 0), ("j", "i", 1)):
        for place in range(FEW):
            row, flat, index, store = itertools.islice(idents, 4)
            lines += [
                f'  %{row} i32 = add $"{first}", {2 * place + odd:#x}',
                f'  %{flat} i32 = mul %{row}, $"a.pitch1"',
                f'  %{index} i32 = add %{flat}, $"{other}"',
                f'  %{store} none = store $"&a", %{index}, 0x0 array "a" shift 2',
            ]
    made = function('param "a" int32[2]\n' + "\n".join([*lines, "  return\n"]))
    every, meetings = places(made), Meetings(made)
    pairs = itertools.product(every[:FEW], every[FEW:])
    assert all(meetings.between(*pair, now=True) == APART for pair in pairs)
