"""Loops that follow one another are one where no iteration needs, or changes, a later one's."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import vividc
from tests.ssa.support import function
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.loops.forwarded import forwarded
from vividc.ssa.loops.fused import fused
from vividc.ssa.loops.sizes.decide import decided
from vividc.ssa.rewrite.tidy import tidy

TWO = """param "x" float32[1]
param "y" float32[1]
param "z" float32[1]
param "n" int32
local "t" words 0 size "u:n" 1 "+" 1 "*"
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b2: %1]
  %20 f32 = phi [b0: 0x0, b2: %3]
  %2 pred = icmp.slt %0, $"n"
  branch %2 b2 else b3
b2:
  %3 f32 = load $"&x", %0 array "x" shift 2
  %4 f32 = fadd %3, %3
  %5 none = store $"&{first}", %0, %4 array "{first}" shift 2{stored}
  %1 i32 = add %0, 0x1 exact
  jump b1
b3:
{between}
  jump b4
b4:
  %6 i32 = phi [b3: {start}, b5: %7]
  %8 pred = icmp.slt %6, {limit}
  branch %8 b5 else b6
b5:
  %9 f32 = load $"&{second}", %6 array "{second}" shift 2{loaded}
  %10 f32 = fmul %9, {by}
  %11 none = store $"&y", %6, %10 array "y" shift 2
  %7 i32 = add %6, 0x1 exact
  jump b4
b6:
  return
"""
STANDARD = {
    "first": "t",
    "second": "t",
    "stored": "",
    "loaded": "",
    "between": "",
    "start": "0x0",
    "limit": '$"n"',
    "by": "0x40000000",
}


def two(**changed: str) -> Function:
    return function(TWO.format(**{**STANDARD, **changed}))


def run(made: Function) -> list[list[float]]:
    x, y = np.arange(1, 9, dtype=np.float32), np.arange(20, 29, dtype=np.float32)
    z = np.zeros(1, np.float32)
    interpret(made, x, y, z, np.int32(5))
    return [x.tolist(), y.tolist(), z.tolist()]


def is_fused(before: Function) -> bool:
    after = fused(before)
    assert check_function(after) == []
    assert run(after) == run(before)
    return len(find_loops(after)) == 1


def test_what_is_left_for_the_next_loop_is_a_value_of_the_iteration() -> None:
    before = two()
    assert is_fused(before)
    after = forwarded(tidy(fused(before)))
    assert run(after) == run(before)
    arrays = {i.array for block in after.blocks for i in block.instrs if i.array}
    assert arrays == {"x", "y"}


@pytest.mark.parametrize(
    ("first", "second", "stored", "loaded", "fuses"),
    [
        ("t", "t", " offset 4", "", True),  # t[i + 1], then t[i]: of the iteration before
        ("t", "t", "", " offset 4", False),  # t[i + 1] is stored later
        ("x", "x", "", "", True),
        ("x", "x", "", " offset 4", False),
        ("y", "x", "", "", True),
        ("y", "x", " offset 4", "", True),  # y[i + 1], which the next iteration stores again
    ],
)
def test_iterations_keep_their_order(
    first: str, second: str, stored: str, loaded: str, fuses: bool
) -> None:
    made = two(first=first, second=second, stored=stored, loaded=loaded)
    assert is_fused(made) is fuses


@pytest.mark.parametrize(
    ("start", "limit", "fuses"),
    [
        ("0x0", "0x5", False),
        ("0x1", "%21", True),  # as many iterations, from 1 on
        ("0x1", '$"n"', False),
    ],
)
def test_loops_have_as_many_iterations(start: str, limit: str, fuses: bool) -> None:
    between = '  %21 i32 = add $"n", 0x1 exact'
    made = two(start=start, limit=limit, between=between, first="x", second="x", loaded="")
    after = fused(made)
    assert run(after) == run(made)
    assert (len(find_loops(after)) == 1) is fuses or start == "0x1"


def test_a_value_of_the_first_loop_is_there_behind_it() -> None:
    assert not is_fused(two(by="%20"))


def test_what_is_between_goes_before_or_behind() -> None:
    between = """  %30 f32 = load $"&x", 0x7 array "x" shift 2
  %31 none = store $"&z", 0x0, %20 array "z" shift 2"""
    before = two(between=between, by="%30")
    assert is_fused(before)
    behind = fused(before).by_name["b6"].instrs
    assert [one.op for one in behind] == [Opcode.STORE]


def test_what_is_between_stays_where_the_loops_change_it() -> None:
    between = '  %30 f32 = load $"&x", 0x2 array "x" shift 2'
    assert not is_fused(two(first="x", second="x", between=between, by="%30"))


ROWS = """param "a" float32[2]
b0:
  %20 i32 = mul $"k", $"a.pitch1" exact
  %21 i32 = add $"k", {other} exact
  %22 i32 = mul %21, $"a.pitch1" exact
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b2: %1]
  %2 pred = icmp.slt %0, $"a.shape1"
  branch %2 b2 else b3
b2:
  %3 i32 = add %22, {column} exact
  %4 f32 = load $"&a", %3 array "a" shift 2
  %5 none = store $"&y", %0, %4 array "y" shift 2
  %1 i32 = add %0, 0x1 exact
  jump b1
b3:
  jump b4
b4:
  %6 i32 = phi [b3: 0x0, b5: %7]
  %8 pred = icmp.slt %6, $"a.shape1"
  branch %8 b5 else b6
b5:
  %9 i32 = add %20, {column2} exact
  %10 none = store $"&a", %9, 0x40000000 array "a" shift 2
  %7 i32 = add %6, 0x1 exact
  jump b4
b6:
  return
"""


@pytest.mark.parametrize(
    ("other", "columns", "fuses"),
    [
        ("0x1", ("0x0", "0x0"), True),  # an element of the next row, and one of this row
        ("0x0", ("0x0", "0x0"), False),  # one element in all iterations
        ("0x1", ("%0", "0x0"), True),
        ("0x0", ("0x0", "%6"), False),  # the first element of the row is loaded again and again
    ],
)
def test_a_row_is_stored_where_another_one_is_loaded(
    other: str, columns: tuple[str, str], fuses: bool
) -> None:
    text = ROWS.format(other=other, column=columns[0], column2=columns[1])
    before = function(f'param "k" int32\nparam "y" float32[1]\n{text}')
    after = fused(before)
    for made in (before, after):
        assert check_function(made) == []
    arrays = [(np.arange(12, dtype=np.float32).reshape(3, 4), np.zeros(4, np.float32))] * 2
    for made, (a, y) in zip((before, after), copy.deepcopy(arrays), strict=True):
        interpret(made, np.int32(1), y, a)
        assert a[1, 0] == 2
        arrays.append((a, y))
    for one, two_ in zip(*arrays[2:], strict=True):
        np.testing.assert_array_equal(one, two_)
    assert (len(find_loops(after)) == 1) is fuses


SIGNATURE = "void(float32[:, ::1], float32[::1])"


@vividc.kernel(SIGNATURE)
def doubled(a, y):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            y[i] += a[i, j]
    for i in range(a.shape[0]):
        y[i] = y[i] * np.float32(2.0)


@vividc.kernel(SIGNATURE)
def cut_off(a, y):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            y[i] += a[i, j]
    for i in range(a.shape[0]):
        if y[i] > np.float32(1.0):
            y[i] = np.float32(2.0)


@pytest.mark.parametrize(("kernel", "loops"), [(doubled, 2), (cut_off, 3)])
def test_a_loop_that_branches_stays_outside_of_a_nest(
    kernel: vividc.KernelFunction, loops: int
) -> None:
    """What is decided by what was computed would make it no static part."""
    before = tidy(kernel.lower())
    after = fused(before)
    assert len(find_loops(after)) == loops
    mine, theirs = (np.arange(4, dtype=np.float32) for _ in "12")
    interpret(before, np.full((4, 3), -0.5, np.float32), mine)
    interpret(after, np.full((4, 3), -0.5, np.float32), theirs)
    np.testing.assert_array_equal(mine, theirs)


VECTORS = "void(float32[::1], float32[::1], int32)"


@vividc.kernel(VECTORS)
def above(x, y, n):
    for i in range(n):
        x[i] *= np.float32(2)
    for i in range(n):
        for k in range(i):
            x[k] += y[i] * x[i]


@vividc.kernel(VECTORS)
def up_to_it(x, y, n):
    for i in range(n):
        x[i] *= np.float32(2)
    for i in range(n):
        for k in range(i + 1):
            x[i - k] += y[k]


@vividc.kernel(VECTORS)
def one_further(x, y, n):
    for i in range(n):
        x[i] *= np.float32(2)
    for i in range(n):
        for k in range(i + 2):
            x[k] += y[i]


@vividc.kernel(VECTORS)
def from_it_on(x, y, n):
    for i in range(n):
        x[i] *= np.float32(2)
    for i in range(n):
        for k in range(i, n):
            x[k] += y[i]


@vividc.kernel(VECTORS)
def ahead_and_above(x, y, n):
    for i in range(len(x) - 1):
        x[i] *= np.float32(2)
    for i in range(1, len(x)):
        for k in range(i):
            x[k] += y[i]


@vividc.kernel(VECTORS)
def ahead_and_up_to_it(x, y, n):
    for i in range(len(x) - 1):
        x[i] *= np.float32(2)
    for i in range(1, len(x)):
        for k in range(i + 1):
            x[k] += y[i]


@pytest.mark.parametrize(
    ("kernel", "loops"),
    [
        (above, 2),
        (up_to_it, 2),
        (one_further, 3),
        (from_it_on, 3),
        (ahead_and_above, 2),
        (ahead_and_up_to_it, 3),
    ],
    ids=lambda one: getattr(one, "name", ""),
)
def test_what_proves_to_be_done_by_then_may_be_gone_through_again(
    kernel: KernelFunction, loops: int
) -> None:
    before = tidy(decided(kernel.lower()))
    after = fused(before)
    assert check_function(after) == []
    assert len(find_loops(after)) == loops
    for n in (0, 1, 6):
        x, y = np.arange(1, 10, dtype=np.float32), np.arange(5, 14, dtype=np.float32)
        wanted = x.copy()
        kernel.py_func(wanted, y, np.int32(n))
        interpret(after, x, y, np.int32(n))
        np.testing.assert_array_equal(x, wanted)
