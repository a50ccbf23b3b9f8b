"""Two loops in one that runs once: what is written, what is refused, and that it means the same."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.frontend import KernelFunction, kernel
from vividc.ssa.check import check_function
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.loops.join import join
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy
from vividc.ssa.text import parse, to_text

SIGNATURE = "void(int32[::1], int32[::1])"

TWO_LOOPS = """\
function "two"
param "x" int32[1]
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x00000000, b2: %2]
  %1 pred = icmp.slt %0, $"x.shape0"
  branch %1 b2 else b3
b2:
  %6 none = store $"&x", %0, %0 array "x" shift 2
  %2 i32 = add %0, 0x00000001
  jump b1
b3:
  jump b4
b4:
  %3 i32 = phi [b3: 0x00000000, b5: %5]
  %4 pred = icmp.slt %3, 0x00000004
  branch %4 b5 else b6
b5:
  %5 i32 = add %3, 0x00000001
  jump b4
b6:
  return
"""

JOINED = """\
b0:
  jump both
both:
  %7 i32 = phi [b0: 0x00000000, both.latch: %9]
  %8 pred = icmp.slt %7, 0x00000001
  branch %8 both.body else b6
both.body:
  jump b1
both.latch:
  %9 i32 = add %7, 0x00000001 exact
  jump both
b1:
  %0 i32 = phi [both.body: 0x00000000, b2: %2]
"""


def outermost(function: Function) -> list[Loop]:
    """Loops in no other one, in order."""
    loops = find_loops(function)
    outer = [one for one in loops if not any(one.header in o.blocks - {o.header} for o in loops)]
    order = [block.name for block in function.blocks]
    return sorted(outer, key=lambda one: order.index(one.header))


def test_the_loop_around_runs_once() -> None:
    function = parse(TWO_LOOPS)
    made = join(function, *outermost(function))
    assert not isinstance(made, Refusal)
    assert check_function(made.function) == []
    text = to_text(made.function)
    assert JOINED in text
    assert [one.header for one in outermost(made.function)] == ["both"]
    assert "branch %4 b5 else both.latch" in text


@kernel(SIGNATURE)
def fill_and_add(x, y):
    for i in range(len(x)):
        x[i] = i
    for i in range(len(y)):
        y[i] += x[0]


@kernel(SIGNATURE)
def sum_read_after(x, y):
    total = 0
    for i in range(len(x)):
        x[i] = i
    for i in range(len(y)):
        total += y[i]
    x[0] = total


@kernel(SIGNATURE)
def left_early(x, y):
    for i in range(len(x)):
        x[i] = i
    for i in range(len(y)):
        if y[i] == 3:
            break
        y[i] = 3


def test_what_is_joined_means_the_same() -> None:
    function = tidy(fill_and_add.lower())
    made = join(function, *outermost(function))
    assert not isinstance(made, Refusal)
    assert check_function(made.function) == []
    for length in (0, 1, 5):
        mine, theirs = ([np.ones(5, np.int32), np.ones(length, np.int32)] for _ in "12")
        interpret(function, *mine)
        interpret(made.function, *theirs)
        assert all(np.array_equal(a, b) for a, b in zip(mine, theirs, strict=True))


@pytest.mark.parametrize(
    ("tested", "reason"),
    [
        (sum_read_after, "a value of theirs is read after them"),
        (left_early, "a loop has exits in its body"),
    ],
    ids=["sum", "break"],
)
def test_what_is_refused(tested: KernelFunction, reason: str) -> None:
    function = tidy(tested.lower())
    first, second = outermost(function)
    assert join(function, first, second) == Refusal(reason)
    assert join(function, second, first) == Refusal("they do not follow one another")
