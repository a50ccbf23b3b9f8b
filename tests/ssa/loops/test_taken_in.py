"""What is written before a loop is its first iteration again, if it is one, and one runs."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.ssa.support import function
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Const, Function
from vividc.ssa.loops.begun_sums import begun_sums
from vividc.ssa.loops.sizes.versions import for_sizes
from vividc.ssa.loops.taken_in import taken_in
from vividc.ssa.rewrite.tidy import tidy

M = "float32[:, ::1]"
ROOTS = """param "x" float32[1]
param "n" int32
b0:
  %0 pred = icmp.slt {first}, $"x.shape0"
  branch %0 b1 else b5
b1:
  %1 f32 = load $"&x", {before} array "x" shift 2
  %2 f32 = sqrt %1
  %3 none = store $"&x", {before}, %2 array "x" shift 2
  {behind}
  jump b2
b2:
  %5 i32 = phi [b1: {first}, b3: %6]
  %7 pred = icmp.slt %5, $"x.shape0"
  branch %7 b3 else b5
b3:
  %8 f32 = load $"&x", %5 array "x" shift 2
  %9 f32 = sqrt %8
  %10 none = store $"&x", %5, %9 array "x" shift 2
  %6 i32 = add %5, 0x1 exact
  jump b2
b5:
  return
"""
NOTHING = "%4 i32 = add 0x0, 0x0"


def starts_of(made: Function) -> list[int]:
    """The constants that counters start with."""
    phis = [phi for block in made.blocks for phi in block.phis]
    return [one.word for phi in phis for _, one in phi.incoming if isinstance(one, Const)]


def test_an_iteration_is_taken_in() -> None:
    before = function(ROOTS.format(first="0x3", before="0x2", behind=NOTHING))
    made = taken_in(before)
    assert check_function(made) == []
    assert starts_of(made) == [2]
    stores = [one for block in made.blocks for one in block.instrs if one.op is Opcode.STORE]
    assert len(stores) == 1
    for size in (1, 4, 6):
        arrays = [np.linspace(2, 9, size, dtype=np.float32) for _ in (before, made)]
        for one, array in zip((before, made), arrays, strict=True):
            interpret(one, array, np.int32(0))
        np.testing.assert_array_equal(*arrays)


@pytest.mark.parametrize(
    ("first", "before", "behind"),
    [
        ("0x3", "0x1", NOTHING),  # another element
        ("0x3", '$"n"', NOTHING),
        ("0x3", "0x2", '%4 none = store $"&x", $"n", 0x0 array "x" shift 2'),
        ("0x3", "0x2", '%4 f32 = load $"&x", $"n" array "x" shift 2'),
    ],
)
def test_other_code_stays_before_the_loop(first: str, before: str, behind: str) -> None:
    made = function(ROOTS.format(first=first, before=before, behind=behind))
    assert taken_in(made) is made


def test_a_loop_that_may_not_run_at_all_stays() -> None:
    text = ROOTS.format(first="0x3", before="0x2", behind=NOTHING)
    made = function(text.replace('icmp.slt 0x3, $"x.shape0"', 'icmp.slt 0x1, $"x.shape0"'))
    assert taken_in(made) is made


def test_a_loop_that_carries_a_number_stays() -> None:
    text = ROOTS.format(first="0x3", before="0x2", behind=NOTHING)
    text = text.replace("b2:\n", "b2:\n  %20 f32 = phi [b1: %2, b3: %9]\n")
    made = function(text.replace("sqrt %8", "fadd %8, %20"))
    assert taken_in(made) is made


STALE = """param "x" float32[1]
param "y" float32[1]
b0:
  %0 pred = icmp.slt 0x3, $"x.shape0"
  branch %0 b1 else b5
b1:
  %1 f32 = load $"&x", 0x2 array "x" shift 2
  %2 f32 = sqrt %1
  %3 none = store $"&x", 0x2, %2 array "x" shift 2
  %4 f32 = load $"&x", 0x2 array "x" shift 2
  %11 f32 = fadd %4, %4
  %12 none = store $"&y", 0x2, %11 array "y" shift 2
  jump b2
b2:
  %5 i32 = phi [b1: 0x3, b3: %6]
  %7 pred = icmp.slt %5, $"x.shape0"
  branch %7 b3 else b5
b3:
  %8 f32 = load $"&x", %5 array "x" shift 2
  %9 f32 = sqrt %8
  %10 none = store $"&x", %5, %9 array "x" shift 2
  %13 f32 = load $"&x", %5 array "x" shift 2
  %14 f32 = fadd {read}, {read}
  %15 none = store $"&y", %5, %14 array "y" shift 2
  %6 i32 = add %5, 0x1 exact
  jump b2
b5:
  return
"""


@pytest.mark.parametrize(("read", "is_taken"), [("%13", True), ("%4", False)])
def test_what_is_loaded_between_stores_and_read_later_keeps_these(
    read: str, is_taken: bool
) -> None:
    before = function(STALE.format(read=read))
    made = taken_in(before)
    assert (made is not before) == is_taken
    arrays = [np.linspace(2, 9, 12, dtype=np.float32).reshape(2, 6) for _ in (before, made)]
    for one, pair in zip((before, made), arrays, strict=True):
        interpret(one, *pair)
    np.testing.assert_array_equal(*arrays)


@vividc.kernel(f"void({M})")
def factor(a):
    """cholesky by inner products of slices, the first row before the others."""
    a[0, 0] = np.sqrt(a[0, 0])
    for i in range(1, a.shape[0]):
        for j in range(i):
            a[i, j] -= np.dot(a[i, :j], a[j, :j])
            a[i, j] /= a[j, j]
        a[i, i] -= np.dot(a[i, :i], a[i, :i])
        a[i, i] = np.sqrt(a[i, i])


def test_rows_of_a_triangle_begin_with_the_first() -> None:
    sized = for_sizes(tidy(factor.lower()))
    assert sized is not None
    before = tidy(begun_sums(sized.function))
    after = taken_in(before)
    assert check_function(after) == []
    assert starts_of(before).count(1) == starts_of(after).count(1) + 1
    for size in (1, 2, 7):
        spread = np.random.default_rng(size).random((size, size), np.float32)
        square = (spread @ spread.T + size * np.eye(size)).astype(np.float32)
        arrays = [square.copy() for _ in (before, after)]
        for one, array in zip((before, after), arrays, strict=True):
            interpret(one, array)
        np.testing.assert_array_equal(*arrays)
