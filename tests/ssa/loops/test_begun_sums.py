"""Sums that begin with what they are added to, or taken from."""

from __future__ import annotations

import numpy as np
import pytest

from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function, Instr
from vividc.ssa.loops.begun_sums import begun_sums

LOOP = """param "x" float32[1]
param "y" float32[1]
param "n" int32
b0:
  %0 f32 = load $"&y", 0x0 array "y" shift 2
  jump b1
b1:
  %1 i32 = phi [b0: 0x0, b2: %2]
  %3 f32 = phi [b0: {start}, b2: %4]
  %5 pred = icmp.slt %1, $"n"
  branch %5 b2 else b3
b2:
  %6 f32 = load $"&x", %1 array "x" shift 2
  %4 f32 = {adds}
  %2 i32 = add %1, 0x1 exact
  jump b1
b3:
  %9 f32 = load $"&y", 0x1 array "y" shift 2
  %7 f32 = {last}
  %8 none = store $"&y", 0x0, {stored} array "y" shift 2
  return
"""


def loop(
    adds: str = "fadd %3, %6", last: str = "fadd %0, %3", start: str = "0x0", stored: str = "%7"
) -> Function:
    return function(LOOP.format(adds=adds, last=last, start=start, stored=stored))


def run(made: Function) -> list[float]:
    x, y = np.arange(1, 6, dtype=np.float32), np.array([7, 3], np.float32)
    interpret(made, x, y, np.int32(5))
    return y.tolist()


@pytest.mark.parametrize("adds", ["fadd %3, %6", "fadd %6, %3", "fma %6, %6, %3"])
@pytest.mark.parametrize("last", ["fadd %0, %3", "fadd %3, %0", "fsub %0, %3"])
@pytest.mark.parametrize("start", ["0x0", "0x80000000"])
def test_a_sum_begins_with_what_it_is_added_to(adds: str, last: str, start: str) -> None:
    before = loop(adds, last, start)
    after = begun_sums(before)
    assert check_function(after) == []
    assert run(after) == run(before)
    behind = [instr.op for instr in after.by_name["b3"].instrs]
    assert behind == [Opcode.LOAD, Opcode.STORE]
    summed = after.definitions[4]
    taken = {Opcode.FSUB, Opcode.FNMA}
    assert isinstance(summed, Instr)
    assert (summed.op in taken) == last.startswith("fsub")


@pytest.mark.parametrize(
    "other",
    [
        {"start": "0x3f800000"},
        {"last": "fsub %3, %0"},
        {"last": "fmul %0, %3"},
        {"last": "fadd %3, %3"},
        {"adds": "fsub %3, %6"},
        {"adds": "fma %3, %6, %6"},
        {"stored": "%3"},
    ],
    ids=str,
)
def test_other_sums_stay(other: dict[str, str]) -> None:
    before = loop(**other)
    assert begun_sums(before) is before


def test_what_is_loaded_behind_the_loop_is_loaded_before_it() -> None:
    before = loop(last="fadd %9, %3")
    after = begun_sums(before)
    assert check_function(after) == []
    assert run(after) == run(before)
    assert [instr.op for instr in after.by_name["b3"].instrs] == [Opcode.STORE]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  %2 i32 = add", '  %10 none = store $"&y", 0x1, %4 array "y" shift 2\n  %2 i32 = add'),
        ("  %9 f32", '  %10 none = store $"&y", 0x1, 0x0 array "y" shift 2\n  %9 f32'),
        ('%9 f32 = load $"&y", 0x1', '%9 f32 = load $"&y", %1'),
    ],
    ids=["stored in the loop", "stored behind it", "the counter says where"],
)
def test_loads_stay_where_the_loop_may_change_what_they_find(old: str, new: str) -> None:
    text = LOOP.format(adds="fadd %3, %6", last="fadd %9, %3", start="0x0", stored="%7")
    assert old in text
    before = function(text.replace(old, new, 1))
    assert begun_sums(before) is before
