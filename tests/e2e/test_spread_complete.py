"""A loop over prange on sixteen tiles gives what the serial loop gives, or runs on one tile."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable

import numpy as np
import pytest
from numba import prange

import vividc

Case = tuple[str, Callable[..., object], tuple[object, ...], int]
CASES: list[Case] = []
F, I = np.float32, np.int32  # noqa: E741 - types, as in NumPy's own letters
COUNT = np.arange(1, 41).astype(I)


def case(signature: str, *args: object, tiles: int) -> Callable[..., Callable[..., object]]:
    """A kernel, its arguments, and on how many tiles it runs."""

    def add(function: Callable[..., object]) -> Callable[..., object]:
        CASES.append((signature, function, args, tiles))
        return function

    return add


@case("float32(float32[::1])", COUNT.astype(F), tiles=1)
def read_behind(y):
    t = np.zeros(len(y), np.float32)
    for i in prange(len(y)):
        t[i] = y[i]
    return t[0] + t[len(y) - 1]


@case("void(int32[::1], int32[::1])", COUNT % 7, np.zeros(8, I), tiles=1)
def histogram(x, o):
    h = np.zeros(8, np.int32)
    for i in prange(len(x)):
        h[x[i]] += 1
    for j in range(8):
        o[j] = h[j]


@case("boolean(int32[::1])", COUNT, tiles=1)
def flag(x):
    seen = np.zeros(1, np.bool_)
    for i in prange(len(x)):
        if x[i] == 33:
            seen[0] = True
    return seen[0]


@case("void(int32[::1], int32[::1])", COUNT, np.zeros(40, I), tiles=1)
def entered_again(x, o):
    t = np.zeros(40, np.int32)
    for k in range(3):
        for i in prange(40):
            o[i] = t[39 - i] + x[i]
            t[i] = x[i] + k


@case("void(int32[::1], int32[::1])", COUNT, np.zeros(40, I), tiles=16)
def scratch_of_an_iteration(x, o):
    for i in prange(40):
        t = np.zeros(4, np.int32)
        for j in range(4):
            t[j] = x[i] * j
        o[i] = t[3] - t[1]


@case("void(int32[::1], int32[::1])", COUNT, np.zeros(40, I), tiles=16)
def table_made_before(x, o):
    t = np.zeros(8, np.int32)
    for j in range(8):
        t[j] = j * j
    for i in prange(40):
        o[i] = t[x[i] & 7]


@case("void(int32[::1], int32)", np.full(40, 7, I), I(0), tiles=16)
def not_entered(y, m):
    if m > 3:
        for i in prange(len(y)):
            y[i] = 1


@case("void(int32[::1], int32)", np.full(40, 7, I), I(9), tiles=16)
def entered(y, m):
    if m > 3:
        for i in prange(len(y)):
            y[i] = 1


@case("void(int32[::1], int32)", np.full(40, 7, I), I(0), tiles=16)
def left_before(y, m):
    if m < 3:
        return
    for i in prange(len(y)):
        y[i] = 1


@case("void(int32[::1], int32)", np.full(40, 7, I), I(0), tiles=16)
def around_it_no_pass(y, m):
    for k in range(m):
        for i in prange(len(y)):
            y[i] = k


@case("int32(int32[::1], int32)", COUNT, I(5), tiles=1)
def returned_through_a_phi(x, m):
    s = np.int32(3)
    if m > 2:
        for i in prange(len(x)):
            s += x[i]
    return s


@case("int32(int32[::1], int32)", COUNT, I(1), tiles=1)
def returned_otherwise(x, m):
    s = np.int32(3)
    if m < 2:
        return np.int32(7)
    for i in prange(len(x)):
        s += x[i]
    return s


@case("void(int32[::1], int32)", np.zeros(40, I), I(9), tiles=1)
def bound_of_an_outer_loop(y, t):
    for k in range(t):
        for i in prange(k):
            y[i] += k


@case("void(int32[::1], int32)", np.zeros(40, I), I(33), tiles=11)
def bound_of_a_quotient(y, n):
    for i in prange(n // 3):
        y[i] = i


@case("void(int32[::1], int32)", np.zeros(40, I), I(3), tiles=16)
def within_a_while(y, t):
    while t > 0:
        for i in prange(len(y)):
            y[i] += t
        t -= 1


@case("int32(int32[::1])", COUNT, tiles=1)
def last_value(x):
    s = np.int32(0)
    for i in prange(len(x)):
        s = x[i]
    return s


@case("int32(int32[::1])", COUNT, tiles=1)
def last_index(x):
    i = np.int32(0)
    for j in prange(len(x)):
        x[j] += 1
        i = np.int32(j)
    return i


@case("void(int8[::1], int8[::1])", np.arange(101).astype(np.int8), np.ones(101, np.int8), tiles=16)
def bytes_at_borders(x, y):
    for i in prange(1, len(x) - 1):
        if x[i] % 3:
            y[i] = x[i]


@case("void(boolean[::1], int32[::1])", np.ones(101, np.bool_), np.arange(101).astype(I), tiles=16)
def flags_at_borders(y, x):
    for i in prange(len(x)):
        y[i] = x[i] % 5 == 0


@case("void(uint8[::1], int32[::1])", np.full(301, 5, np.uint8), np.arange(300).astype(I), tiles=16)
def bytes_backwards(y, x):
    for i in prange(len(x)):
        y[300 - i] = x[i] & 255


@case("void(int32[::1], int32[::1], int32[::1])", COUNT[::-1] - 1, COUNT, np.zeros(40, I), tiles=16)
def gather(p, x, y):
    for i in prange(len(p)):
        y[i] = x[p[i]]


@case("void(int32[::1], int32[::1], int32[::1])", COUNT[::-1] - 1, COUNT, np.zeros(40, I), tiles=1)
def scatter(p, x, y):
    for i in prange(len(p)):
        y[p[i]] = x[i]


@case("void(int16[:, ::1], int16[:, ::1])", np.arange(640).reshape(64, 10).astype(np.int16), np.zeros((64, 10), np.int16), tiles=16)  # fmt: skip # noqa: E501
def rows_of_halves(x, y):
    for i in prange(64):
        for j in range(9):
            y[i, j] = x[63 - i, j + 1]


@pytest.mark.parametrize(
    ("signature", "function", "args", "tiles"), CASES, ids=[item[1].__name__ for item in CASES]
)
def test_all_tiles_give_what_the_serial_loop_gives(
    signature: str, function: Callable[..., object], args: tuple[object, ...], tiles: int
) -> None:
    kernel = vividc.kernel(signature)(function)  # type: ignore[arg-type]
    args = tuple(np.ascontiguousarray(a) if isinstance(a, np.ndarray) else a for a in args)
    expected, found = copy.deepcopy(args), copy.deepcopy(args)
    value = function(*expected)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        program = vividc.compile(kernel, fabric="vivid")
        result = vividc.simulate(program, *found, fabric="vivid")
    for mine, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert result.value == value
    assert len(result.stats["tiles"]) == tiles
    one_tile = [str(item.message) for item in told if "on one tile" in str(item.message)]
    assert len(one_tile) == (tiles == 1)
    assert all(f"{__name__.rpartition('.')[2]}.py:" in text for text in one_tile)
