"""What loops count beside their counters is made of these."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.ssa.support import function
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.loops.sizes.by_counters import by_counters
from vividc.ssa.rewrite.tidy import tidy

POINTER = """param "x" int32[1]
param "n" int32
b0:
  jump b1
b1:
  %0 i32 = phi [b0: {first}, b2: %1]
  %2 i32 = phi [b0: 0x4, b2: %3]
  %4 pred = icmp.slt %0, $"x.shape0"
  branch %4 b2 else b3
b2:
  %5 none = store $"&x", %2, %0 array "x"
  %3 i32 = add %2, {step}
  %1 i32 = add %0, 0x1 exact
  jump b1
b3:
  %6 i32 = add %0, %2
  return %6
"""


@pytest.mark.parametrize(("first", "step"), [("0x1", "0x4"), ("0x1", "0x0"), ("0x3", "0x4")])
@pytest.mark.parametrize("size", [1, 2, 3, 6])
def test_a_pointer_is_made_of_the_counter(first: str, step: str, size: int) -> None:
    before = function(POINTER.format(first=first, step=step))
    after = by_counters(before)
    assert check_function(after) == []
    assert len(after.by_name["b1"].phis) == 1
    arrays = [np.zeros(size + 1, np.int32) for _ in (before, after)]
    values = [
        interpret(made, array, np.int32(0))
        for made, array in zip((before, after), arrays, strict=True)
    ]
    assert values[0] == values[1]
    np.testing.assert_array_equal(*arrays)


def test_what_an_iteration_loads_is_no_number_from_outside() -> None:
    text = POINTER.replace("add %2, {step}", 'load $"&x", %2 array "x"').format(first="0x0")
    assert len(by_counters(function(text)).by_name["b1"].phis) == 2


@vividc.kernel("void(float32[:, :, ::1], float32[:, ::1])")
def summed(a, x):
    x[:] = np.sum(a, axis=0)


def test_sums_along_an_axis_have_counters_alone() -> None:
    made = tidy(by_counters(tidy(summed.lower())))
    nests = [one for one in find_loops(made) if len(one.blocks) > 2]
    assert nests
    assert all(len(made.by_name[loop.header].phis) == 1 for loop in nests)
    a, x = np.arange(24, dtype=np.float32).reshape(3, 4, 2), np.zeros((4, 2), np.float32)
    interpret(made, a, x)
    np.testing.assert_array_equal(x, a.sum(axis=0))
