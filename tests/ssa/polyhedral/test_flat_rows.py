"""Matrices and own arrays by flat indices: as products and numpy's own loops address them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vividc
from tests.ssa.support import function
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.scop import find_scop
from vividc.ssa.rewrite.refusal import Refusal

NEST = """param "a" int32[2]
local "t" words 0 size "s:a.shape0" "s:a.shape1" "*" 1 "*"
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b5: %1]
  %2 pred = icmp.slt %0, $"a.shape0"
  branch %2 b2 else b6
b2:
  %3 i32 = mul %0, $"a.shape1"
  jump b3
b3:
  %4 i32 = phi [b2: {first}, b4: %5]
  %6 pred = icmp.slt %4, $"{limit}"
  branch %6 b4 else b5
b4:
  %7 i32 = add %3, {column}
  %8 none = store $"&{array}", %7, %0 array "{array}" shift 2{offset}
  %5 i32 = add %4, 0x1 exact
  jump b3
b5:
  %1 i32 = add %0, 0x1 exact
  jump b1
b6:
  return
"""
STANDARD = {"array": "t", "first": "0x0", "limit": "a.shape1", "column": "%4", "offset": ""}


def subscripts(**given: str) -> tuple[Form, ...] | str:
    """Of the store, or why there are none."""
    changed = {**STANDARD, **given}
    array, text = changed["array"], NEST.format(**changed)
    made = find_scop(function(text), "b1")
    if isinstance(made, Refusal):
        return made.reason
    [statement] = made.statements
    [access] = statement.accesses.values()
    assert made.rows.keys() == ({"t"} if array == "t" else set())
    return access.subscripts


@pytest.mark.parametrize("array", ["t", "a"])
def test_an_index_is_of_a_row_and_a_column(array: str) -> None:
    assert subscripts(array=array) == (symbol("i0"), symbol("i1"))


def test_an_offset_is_of_the_column() -> None:
    before = symbol("i1").plus(Form((), -1))
    assert subscripts(first="0x1", offset=" offset -4") == (symbol("i0"), before)


@pytest.mark.parametrize(
    "given",
    [
        {"limit": "n"},
        {"first": "0xffffffff"},
        {"offset": " offset -4"},
        {"offset": " offset 4"},
        {"column": "%0"},
        {"array": "b"},
    ],
    ids=["behind its row", "before it", "by an offset", "behind it so", "any", "other rows"],
)
def test_what_may_be_in_another_row_is_refused(given: dict[str, str]) -> None:
    array = given.get("array", "t")
    assert subscripts(**given) == f"a subscript of {array} is not affine"


BYTES = """param "a" int32[2]
param "b" int32[1]
b0:
  %9 i32 = shl $"a.shape1", 0x2
  %10 pred = icmp.sle $"a.shape0", $"a.shape1"
  branch %10 b7 else b6
b7:
  jump b1
b1:
  %0 i32 = phi [b7: 0x0, b5: %1]
  %2 pred = icmp.slt %0, $"a.shape0"
  branch %2 b2 else b6
b2:
  jump b3
b3:
  %4 i32 = phi [b2: 0x0, b4: %5]
  %6 pred = icmp.slt %4, %0
  branch %6 b4 else b5
b4:
  %3 i32 = mul %0, %9
  %11 i32 = shl %4, 0x2
  %7 i32 = add %3, {column}
  %8 none = store $"&a", %7, %0 array "a"
  %5 i32 = add %4, 0x1 exact
  jump b3
b5:
  %1 i32 = add %0, 0x1 exact
  jump b1
b6:
  return
"""


def test_a_triangle_by_bytes_is_of_rows_and_columns() -> None:
    """A column below the diagonal is in its row if there are no more rows than columns."""
    made = find_scop(function(BYTES.format(column="%11")), "b1")
    assert not isinstance(made, Refusal), made.reason
    [access] = made.statements[0].accesses.values()
    assert access.subscripts == (symbol("i0"), symbol("i1"))


def test_what_lies_between_elements_is_refused() -> None:
    made = find_scop(function(BYTES.format(column="%4")), "b1")
    assert isinstance(made, Refusal)


M = "float32[:, ::1]"


@vividc.kernel(f"void(float32, {M}, {M}, {M})")
def product(alpha: Any, c: Any, a: Any, b: Any) -> None:
    c[:] = alpha * a @ b + c


@pytest.fixture(scope="module")
def compiled() -> vividc.Program:
    return vividc.compile(product, effort="fast")


@pytest.mark.parametrize("shape", [(14, 14, 14), (3, 5, 2), (1, 4, 9), (7, 1, 1), (4, 0, 6)])
def test_a_product_of_a_temporary_is_given_other_loops(
    compiled: vividc.Program, shape: tuple[int, int, int]
) -> None:
    n, k, m = shape
    rng = np.random.default_rng(1)
    made = [rng.random(size, np.float32) for size in ((n, m), (n, k), (k, m))]
    expected = [one.copy() for one in made]
    product(np.float32(1.5), *expected)
    kinds = {one.kind for loop in compiled.loops for one in loop.transforms if one.chosen}
    assert "restructuring" in kinds
    vividc.simulate(compiled, np.float32(1.5), *made)
    for mine, numbas in zip(made, expected, strict=True):
        np.testing.assert_allclose(mine, numbas, rtol=1e-5)


DEEP = """param "a" int32[3]
b0:
  %9 i32 = mul $"a.shape1", $"a.shape2"
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b5: %1]
  %2 pred = icmp.slt %0, $"a.shape1"
  branch %2 b2 else b6
b2:
  jump b3
b3:
  %4 i32 = phi [b2: 0x0, b4: %5]
  %6 pred = icmp.slt %4, $"{limit}"
  branch %6 b4 else b5
b4:
  %3 i32 = mul %0, $"a.shape2"
  %11 i32 = add %3, %4
  %12 i32 = add %11, {first}
  %8 none = store $"&a", %12, %0 array "a" shift 2
  %5 i32 = add %4, 0x1 exact
  jump b3
b5:
  %1 i32 = add %0, 0x1 exact
  jump b1
b6:
  return
"""


@pytest.mark.parametrize(("first", "slab"), [("0x0", "0"), ("%9", "1")])
def test_an_index_of_three_dimensions_has_three_subscripts(first: str, slab: str) -> None:
    made = find_scop(function(DEEP.format(limit="a.shape2", first=first)), "b1")
    assert not isinstance(made, Refusal), made.reason
    [access] = made.statements[0].accesses.values()
    assert access.subscripts == (Form((), int(slab)), symbol("i0"), symbol("i1"))


def test_a_column_of_three_dimensions_may_be_behind_its_row() -> None:
    made = find_scop(function(DEEP.format(limit="n", first="0x0")), "b1")
    assert isinstance(made, Refusal)


FIRST = """param "n" int32
param "a" int32[1]
local "t" words 0 size "s:a.shape0" "s:a.shape0" "*" 1 "*"
b0:
  jump b1
b1:
  %0 i32 = phi [b0: 0x0, b3: %1]
  %2 pred = icmp.slt %0, $"a.shape0"
  branch %2 b2 else b6
b2:
  %7 none = store $"&t", %0, 0x1 array "t" shift 2
  jump b4
b4:
  %4 i32 = phi [b2: 0x0, b5: %5]
  %6 pred = icmp.slt %4, $"a.shape0"
  branch %6 b5 else b3
b5:
  %3 i32 = mul %0, $"a.shape0"
  %8 i32 = add %3, %4
  %9 i32 = load $"&t", %8 array "t" shift 2
  %10 none = store $"&a", %4, %9 array "a" shift 2
  %5 i32 = add %4, 0x1 exact
  jump b4
b3:
  %1 i32 = add %0, 0x1 exact
  jump b1
b6:
  return
"""


def test_the_first_row_is_a_row() -> None:
    """Indices of its elements have no length; a constant is of the type that is loaded."""
    made = find_scop(function(FIRST), "b1")
    assert not isinstance(made, Refusal), made.reason
    found = {access.subscripts for one in made.statements for access in one.accesses.values()}
    assert (Form((), 0), symbol("i0")) in found
