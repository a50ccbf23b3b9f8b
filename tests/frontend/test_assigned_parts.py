"""Array expressions that are assigned to parts of arrays: numba and the simulator agree, no array
lies between where none is needed, and what overlaps is right.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import SimulationError

SIGNATURE = "(float32[:, ::1], float32[:, ::1], int32)"


def stencil(a, b, n):
    b[1:-1, 1:-1] = a[1:-1, :-2] + a[1:-1, 2:] + a[2:, 1:-1] * a[:-2, 1:-1]


def whole(a, b, n):
    b[:] = a * a + b


def same_part(a, b, n):
    b[1:n] = b[1:n] * b[1:n] + a[1:n]


def in_place(a, b, n):
    b[1:-1] += a[2:] * a[2:]


def made(a, b, n):
    t = np.zeros((4, 6), np.float32)
    t[:, 1:] = a[:, :-1] + b[:, 1:]
    b[0] = t[1] - t[2]


def row_over_all(a, b, n):
    b[:] = a[n] + a[1:2]


def one_operation_in_place(a, b, n):
    b[n, 1:n] += np.float32(2) * a[n, 1:n]


def behind_one_in_place(a, b, n):
    b *= np.float32(2)
    b[:, n] -= a[:, n] * a[n, n]


def product_and_sum(a, b, n):
    b[:4, :4] = a[:4, :4] * a[0, 0] + b[:4, :4]


STRAIGHT = (
    stencil,
    whole,
    same_part,
    in_place,
    made,
    row_over_all,
    one_operation_in_place,
    behind_one_in_place,
    product_and_sum,
)


def shifted(a, b, n):
    a[1:] = a[:-1] + b[1:]


def shifted_by_a_view(a, b, n):
    v = a[:, 1:]
    a[:, :-1] = v * v + v


def transposed(a, b, n):
    a[:4, :4] = a[:4, :4].T + a[:4, :4]


def reversed_rows(a, b, n):
    a[:] = a[::-1] + b


def part_of_an_earlier_iteration(a, b, n):
    v = a[0:2]
    for k in range(3):
        s = k
        if k == 0:
            v = a[s : s + 2]
        a[s : s + 2] = v + b[0:2]


def written_in_between(a, b, n):
    t = a * b + a
    a[0, 0] = 7
    b[:] = t


def renamed_in_between(a, b, n):
    t = b * b + b
    b = a
    b[:] = t


def read_again(a, b, n):
    t = a * b + a
    b[:] = t
    a[1:] = t[:-1] + t[1:]


OVERLAPPING = (
    *(shifted, shifted_by_a_view, transposed, reversed_rows, part_of_an_earlier_iteration),
    *(written_in_between, renamed_in_between, read_again),
)


@pytest.mark.parametrize("function", STRAIGHT + OVERLAPPING)
def test_parts_are_what_numba_makes_them(function: Callable[..., object]) -> None:
    kernel = vividc.kernel(SIGNATURE)(function)
    program = words_in_blocks(kernel.lower())
    a = np.arange(24, dtype=np.float32).reshape(4, 6) / np.float32(4)
    mine, theirs = (a.copy(), a[::-1].copy()), (a.copy(), a[::-1].copy())
    kernel(*theirs, np.int32(3))
    vividc.simulate(program, *mine, 3)
    for one, other in zip(mine, theirs, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(
    "function",
    [
        stencil,
        whole,
        same_part,
        row_over_all,
        one_operation_in_place,
        behind_one_in_place,
        product_and_sum,
    ],
)
def test_no_array_lies_between(function: Callable[..., object]) -> None:
    locals_ = vividc.kernel(SIGNATURE)(function).lower().locals
    assert all(one.name.startswith("raise.") for one in locals_)


def test_what_overlaps_has_an_array_of_its_own() -> None:
    locals_ = vividc.kernel(SIGNATURE)(shifted).lower().locals
    assert any(not one.name.startswith("raise.") for one in locals_)


def broadcast(a, b, n):
    b[:] = a + b


def test_sizes_of_the_run_are_demanded() -> None:
    kernel = vividc.kernel(SIGNATURE)(broadcast)
    program = words_in_blocks(kernel.lower())
    for shape in ((1, 6), (4, 1), (1, 1), (4, 6)):
        a = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
        mine, theirs = np.ones((4, 6), np.float32), np.ones((4, 6), np.float32)
        kernel(a, theirs, np.int32(0))
        vividc.simulate(program, a, mine, 0)
        assert np.array_equal(mine, theirs)
    for shape in ((2, 6), (4, 5), (5, 6)):
        with pytest.raises(SimulationError, match="ValueError"):
            vividc.simulate(program, np.ones(shape, np.float32), np.ones((4, 6), np.float32), 0)


def integers(a, n):
    a[1:] = a[1:] * n + a[1:]
    a[:2] += n


def test_integers_wrap_as_numbas() -> None:
    kernel = vividc.kernel("(int16[::1], int64)")(integers)
    program = words_in_blocks(kernel.lower())
    mine, theirs = (np.arange(6, dtype=np.int16) * 1000 for _ in range(2))
    kernel(theirs, 777)
    vividc.simulate(program, mine, 777)
    assert np.array_equal(mine, theirs)
