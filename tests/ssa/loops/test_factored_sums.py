"""A number that all products of a sum have in common multiplies the sum."""

from __future__ import annotations

import numpy as np
import pytest

from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.loops.factored_sums import factored_sums

NEST = """param "x" float32[1]
param "y" float32[1]
param "a" float32
param "n" int32
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b4: %1]
  %2 pred = icmp.slt %0, $"n"
  branch %2 b2 else b5
b2:
  %3 i32 = phi [b1: 0x0, b3: %4]
  %5 f32 = phi [b1: {start}, b3: %6]
  %7 pred = icmp.slt %3, $"n"
  branch %7 b3 else b4
b3:
  %8 f32 = load $"&x", %3 array "x" shift 2
  %9 f32 = {product}
  %6 f32 = {adds}
  %4 i32 = add %3, 0x1 exact{more}
  jump b2
b4:
  %10 none = store $"&y", %0, %5 array "y" shift 2
  %1 i32 = add %0, 0x1 exact
  jump b1
b5:
  return
"""


def nest(
    product: str = 'fmul $"a", %8', adds: str = "fadd %5, %9", start: str = "0x0", more: str = ""
) -> Function:
    return function(NEST.format(product=product, adds=adds, start=start, more=more))


def run(made: Function) -> list[float]:
    x, y = np.arange(1, 6, dtype=np.float32), np.zeros(5, np.float32)
    interpret(made, x, y, np.float32(3), np.int32(5))
    return y.tolist()


def behind(before: Function) -> list[object]:
    """Operations behind the loop of the sum."""
    after = factored_sums(before)
    assert check_function(after) == []
    assert run(after) == run(before)
    return [one.op for one in after.by_name["b4"].instrs]


@pytest.mark.parametrize(
    ("product", "adds"),
    [
        ('fmul $"a", %8', "fadd %5, %9"),
        ('fmul %8, $"a"', "fadd %9, %5"),
        ('fmul %8, $"a"', "fma %9, %8, %5"),
        ("fmul %8, %8", 'fma %9, $"a", %5'),
    ],
)
def test_a_factor_goes_behind_the_loop(product: str, adds: str) -> None:
    assert behind(nest(product, adds))[0] is Opcode.FMUL


@pytest.mark.parametrize(
    "before",
    [
        nest(start="0x3f800000"),
        nest("fmul %8, %8"),
        nest(adds="fsub %5, %9"),
        nest('fadd $"a", %8'),
        nest(more='\n  %11 none = store $"&y", %3, %9 array "y" shift 2'),
    ],
    ids=["it begins with a number", "no factor", "a difference", "a sum", "read elsewhere"],
)
def test_other_sums_stay(before: Function) -> None:
    assert factored_sums(before) is before


def test_a_loop_by_itself_keeps_its_factor() -> None:
    text = NEST.format(product='fmul $"a", %8', adds="fadd %5, %9", start="0x0", more="")
    alone = function(text.replace("%1 i32 = add %0, 0x1 exact\n  jump b1", "return"))
    assert len(find_loops(alone)) == 1
    assert factored_sums(alone) is alone
