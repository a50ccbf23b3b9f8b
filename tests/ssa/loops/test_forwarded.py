"""Loads of what the iteration has stored are the value stored."""

from __future__ import annotations

import numpy as np
import pytest

from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.loops.forwarded import forwarded

LOOP = """param "x" float32[1]
param "n" int32
local "t" words 16
b0:
  %20 none = store $"&t", 0x0, 0x3f800000 array "t" shift 2
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b2: %1]
  %2 pred = icmp.slt %0, $"n"
  branch %2 b2 else b3
b2:
  %3 f32 = load $"&x", %0 array "x" shift 2
  %4 f32 = fadd %3, %3
  %5 none = store $"&t", %0, %4 array "t" shift 2
{between}
  %6 f32 = load $"&t", {place} array "t" shift 2
  %7 none = store $"&x", %0, %6 array "x" shift 2
  %1 i32 = add %0, 0x1 exact
  jump b1
b3:
{behind}
  return
"""


def loop(place: str = "%0", between: str = "", behind: str = "") -> Function:
    return function(LOOP.format(place=place, between=between, behind=behind))


def run(made: Function) -> list[float]:
    x = np.arange(1, 9, dtype=np.float32)
    interpret(made, x, np.int32(5))
    return x.tolist()


def loads_of_t(before: Function) -> int:
    after = forwarded(before)
    assert check_function(after) == []
    assert run(after) == run(before)
    every = [one for block in after.blocks for one in block.instrs if one.array == "t"]
    loads = sum(one.op is Opcode.LOAD for one in every)
    assert loads or not every  # nor are there stores that nothing loads
    return loads


def test_an_array_that_nothing_loads_goes() -> None:
    assert loads_of_t(loop()) == 0


@pytest.mark.parametrize("between", ["%3", "0x40000000"])
def test_another_store_may_be_to_the_element(between: str) -> None:
    other = f'  %8 none = store $"&t", 0x2, {between} array "t" shift 2'
    assert loads_of_t(loop(between=other)) == 1


def test_another_store_is_to_another_element() -> None:
    other = '  %8 none = store $"&t", %0, %3 array "t" shift 2 offset 4'
    assert loads_of_t(loop(between=other)) == 0


def test_another_element_is_loaded() -> None:
    assert loads_of_t(loop(place="0x0")) == 1


def test_behind_the_loop_an_element_is_of_another_iteration() -> None:
    behind = """  %9 f32 = load $"&t", 0x0 array "t" shift 2
  %10 none = store $"&x", 0x6, %9 array "x" shift 2"""
    assert loads_of_t(loop(behind=behind)) == 1


def test_an_element_is_loaded_once() -> None:
    behind = """  %9 f32 = load $"&x", 0x1 array "x" shift 2
  %10 f32 = load $"&x", 0x1 array "x" shift 2
  %11 f32 = fadd %9, %10
  %12 none = store $"&x", 0x2, %11 array "x" shift 2
  %13 f32 = load $"&x", 0x1 array "x" shift 2
  %14 none = store $"&x", 0x3, %13 array "x" shift 2"""
    before = loop(behind=behind)
    after = forwarded(before)
    assert run(after) == run(before)
    loads = [one for one in after.by_name["b3"].instrs if one.op is Opcode.LOAD]
    assert len(loads) == 2
