"""Dimensions have one name where a branch has shown that they are equal, and there alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import load
from tests.ssa.support import function
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Input
from vividc.ssa.loops.sizes.one_name import with_one_name

M = "float32[:, ::1]"
ROWS, ROW = Input("a.shape0"), Input("a.shape1")
TESTED = """param "a" int32[2]
param "b" int32[2]
param "n" int32
b0:
  %0 pred = icmp.eq $"a.shape0", $"a.shape1"
  %1 pred = icmp.eq $"b.shape0", {other}
  %2 pred = {joined} %0, %1
  branch %2 b1 else b2
b1:
  %3 i32 = mul $"a.shape0", $"a.pitch1"
  %4 i32 = add %3, $"b.shape0"
  jump b3
b2:
  %5 i32 = add $"a.shape0", $"b.shape0"
  jump b3
b3:
  %6 i32 = phi [b1: $"a.shape0", b2: $"a.shape0"]
  %7 i32 = add $"a.shape0", $"n"
  return %6
"""


def test_rows_and_their_length_have_the_name_of_the_length() -> None:
    made = with_one_name(function(TESTED.format(other='$"a.shape1"', joined="and")))
    assert check_function(made) == []
    assert made.by_name["b1"].instrs[0].operands == (ROW, Input("a.pitch1"))
    assert made.by_name["b1"].instrs[1].operands[1] == ROW
    assert made.by_name["b2"].instrs[0].operands == (ROWS, Input("b.shape0"))
    assert made.by_name["b3"].phis[0].incoming == (("b1", ROW), ("b2", ROWS))
    assert made.by_name["b3"].instrs[0].operands[0] == ROWS


def test_scalars_keep_their_names() -> None:
    made = with_one_name(function(TESTED.format(other='$"n"', joined="and")))
    assert made.by_name["b1"].instrs[1].operands[1] == Input("b.shape0")


def test_one_of_two_tests_shows_nothing() -> None:
    before = function(TESTED.format(other='$"a.shape1"', joined="or"))
    assert with_one_name(before) is before


def test_what_compares_no_dimensions_is_as_it_was() -> None:
    before = function('param "a" int32[2]\nb0:\n  return $"a.shape0"\n')
    assert with_one_name(before) is before


@vividc.kernel(f"void({M}, {M})")
def mirrored(a, b):
    """The upper half of a square matrix, with its factor below."""
    b[:] = np.linalg.cholesky(a) + np.triu(a, k=1)


@vividc.kernel(f"void({M}, {M})")
def turned(a, b):
    if a.shape[0] != b.shape[1] or b.shape[0] != a.shape[1]:
        return
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            b[j, i] += a[i, j]


def test_a_square_matrix_has_one_size_behind_the_test() -> None:
    made = mirrored.lower()
    names = {
        value.key
        for block in made.blocks[1:]
        for item in block.instrs
        for value in item.operands
        if isinstance(value, Input) and ".shape" in value.key and "a." in value.key
    }
    assert names == {"a.shape1"}


@pytest.mark.parametrize("shapes", [((3, 4), (4, 3)), ((3, 4), (3, 4)), ((1, 1), (1, 1))])
def test_elements_are_those_of_python(shapes: tuple[tuple[int, int], ...]) -> None:
    a, b = (np.arange(m * n, dtype=np.float32).reshape(m, n) for m, n in shapes)
    wanted = b.copy()
    turned.py_func(a, wanted)
    interpret(turned.lower(), a, b)
    np.testing.assert_array_equal(b, wanted)


RELATED = """import vividc

@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def related(a, b, c):
    if a.shape[0] != a.shape[1]:
        raise ValueError("square")
    if {test}:
        raise ValueError("sizes")
    for i in range(b.shape[0]):
        b[i] += a[0, 0]
    for i in range(c.shape[0]):
        c[i] += a[a.shape[0] - 1, a.shape[1] - 1]
"""


@pytest.mark.parametrize(
    ("test", "sizes"),
    [
        ("a.shape[0] + b.shape[0] != c.shape[0]", (4, 3, 7)),
        ("b.shape[0] - c.shape[0] != a.shape[0]", (4, 7, 3)),
        ("2 * a.shape[0] != b.shape[0]", (3, 6, 2)),
        ("b.shape[0] != 3 * c.shape[0]", (3, 6, 2)),
        ("b.shape[0] != c.shape[0] + 1", (2, 4, 3)),
        ("a.shape[0] + a.shape[1] != b.shape[0]", (2, 4, 1)),
        ("2 * b.shape[0] != 2 * c.shape[0]", (2, 5, 5)),
        ("b.shape[0] + c.shape[0] != 2 * a.shape[0]", (4, 3, 5)),
        ("b.shape[0] != c.shape[0] or c.shape[0] != a.shape[0]", (4, 4, 4)),
        ("b.shape[0] < c.shape[0] or c.shape[0] < b.shape[0]", (2, 5, 5)),
    ],
)
def test_dimensions_that_are_related_otherwise_keep_their_names(
    test: str, sizes: tuple[int, int, int], tmp_path: Path
) -> None:
    """A sum of three that are in balance is no pair of equal ones."""
    kernel = load(RELATED.format(test=test), tmp_path).related
    rows, *others = sizes
    a = np.arange(rows * rows, dtype=np.float32).reshape(rows, rows) + 1
    mine = [np.zeros(size, np.float32) for size in others]
    wanted = [one.copy() for one in mine]
    kernel.py_func(a, *wanted)
    interpret(kernel.lower(), a, *mine)
    for found, one in zip(mine, wanted, strict=True):
        np.testing.assert_array_equal(found, one)
