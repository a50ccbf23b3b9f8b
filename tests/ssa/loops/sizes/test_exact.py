"""Sums that prove to be exact where they are read, and comparisons of natural numbers."""

from __future__ import annotations

from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function, Instr
from vividc.ssa.loops.sizes.exact import with_exact_sums

COUNTED = """param "x" int32[1]
param "n" int32
b0:
  jump b1
b1:
  %0 i32 = phi [b0: {start}, b2: %1]
  %2 pred = {test}
  %1 i32 = add %0, {step}
  branch %2 b2 else b3
b2:
  %5 none = store $"&x", %0, %1 array "x" shift 2
  jump b1
b3:
  return
"""


def exact(text: str) -> tuple[Function, Instr]:
    before, made = None, function(text)
    while made is not before:
        before, made = made, with_exact_sums(made)
    assert check_function(made) == []
    [step] = [one for b in made.blocks for one in b.instrs if one.id == 1]
    return made, step


def test_a_counter_is_raised_behind_its_test() -> None:
    made, step = exact(COUNTED.format(start="0x0", test='icmp.slt %0, $"n"', step="0x1"))
    assert step.exact
    assert made.block_of[1] == "b2"


def test_a_step_of_two_may_pass_all_words() -> None:
    made, step = exact(COUNTED.format(start="0x0", test='icmp.slt %0, $"n"', step="0x2"))
    assert not step.exact
    assert made.block_of[1] == "b1"


def test_a_counter_that_falls_to_zero_is_natural() -> None:
    text = COUNTED.format(start='$"x.shape0"', test="icmp.ult 0x0, %0", step="0xffffffff")
    made, step = exact(text)
    assert step.exact
    assert made.by_name["b1"].instrs[0].op is Opcode.ICMP_SLT


def test_a_counter_that_begins_anywhere_is_not() -> None:
    text = COUNTED.format(start='$"n"', test="icmp.ult 0x0, %0", step="0xffffffff")
    made, _ = exact(text)
    assert made.by_name["b1"].instrs[0].op is Opcode.ICMP_ULT


GIVEN = """param "x" int32[1]
param "n" int32
b0:
  %0 pred = icmp.sle {least}, $"n"
  branch %0 b1 else b2
b1:
  %1 i32 = add $"n", 0xffffffff
  %2 pred = icmp.ult %1, $"n"
  %3 i32 = select %2, %1, $"x.shape0"
  return %3
b2:
  return 0x0
"""


def test_what_is_known_of_inputs_makes_sums_exact() -> None:
    made, step = exact(GIVEN.format(least="0x1"))
    assert step.exact
    assert made.by_name["b1"].instrs[1].op is Opcode.ICMP_SLT


def test_a_sum_may_be_negative() -> None:
    made, step = exact(GIVEN.format(least="0x0"))
    assert step.exact
    assert made.by_name["b1"].instrs[1].op is Opcode.ICMP_ULT


def test_a_sum_may_wrap() -> None:
    _, step = exact(GIVEN.format(least="0x80000000"))
    assert not step.exact
