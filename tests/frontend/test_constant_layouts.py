"""Constant arrays of any layout, and powers of integers: what numba gets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.e2e.constructs.registry import Construct
from tests.e2e.test_constructs import interpreted
from tests.fuzz.witnesses import run_regions
from vividc.compiler.driver import lower
from vividc.errors import VividcWarning
from vividc.frontend import KernelFunction

BASE = np.arange(24, dtype=np.int32)
LAYOUTS = {
    "c": BASE.reshape(4, 6),
    "f": np.asfortranarray(BASE.reshape(4, 6)),
    "transposed": BASE.reshape(6, 4).T,
    "reversed": BASE.reshape(4, 6)[::-1, ::-1],
    "every-second": np.arange(96, dtype=np.int32).reshape(8, 12)[::2, 1::2],
    "of-fortran": np.asfortranarray(np.arange(40, dtype=np.int32).reshape(5, 8))[1:, 2:],
    "row": np.asfortranarray(BASE[None, :6]),
    "column": np.asfortranarray(BASE[:4, None]),
    "broadcast": np.broadcast_to(BASE[:6], (4, 6)),
    "bytes": np.asfortranarray(BASE.reshape(4, 6).astype(np.int8)),
    "halves": BASE.reshape(6, 4).astype(np.uint16).T,
    "floats": np.asfortranarray(BASE.reshape(4, 6).astype(np.float32)),
    "flags": np.asfortranarray(BASE.reshape(4, 6) % 3 == 1),
}


def read_elements(table: np.ndarray) -> Callable[..., None]:
    def program(o):
        for i in range(table.shape[0]):
            for j in range(table.shape[1]):
                o[i * table.shape[1] + j] = table[i, j]
                o[24 + i * table.shape[1] + j] = table[i - 1, -j]

    return program


def read_whole(table: np.ndarray) -> Callable[..., None]:
    def program(o):
        n = table.size
        for k, v in enumerate(table.ravel()):
            o[k] = v
        for k, v in enumerate(table.T.flatten()):
            o[24 + k] = v
        for k, v in enumerate((table * 2)[0]):
            o[48 + k] = v
        for k, v in enumerate(table[:, 0]):
            o[56 + k] = v
        for k in range(table.shape[1]):
            o[64 + k] = table[:, k].sum() + n

    return program


@pytest.mark.filterwarnings("ignore:.*float64 arithmetic runs in float32")
@pytest.mark.parametrize("read", [read_elements, read_whole])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_constant_array_of_any_layout(read: Callable[..., object], layout: str) -> None:
    kernel = KernelFunction(read(LAYOUTS[layout]), "void(int32[::1])", None)  # type: ignore[arg-type]
    expected, found = np.zeros(72, np.int32), np.zeros(72, np.int32)
    kernel(expected)
    interpreted(Construct(kernel, (), False), (found,))
    np.testing.assert_array_equal(found, expected)


CUBES = {
    "f": np.asfortranarray(BASE.reshape(2, 3, 4)),
    "axes": BASE.reshape(4, 2, 3).transpose(1, 2, 0),
    "reversed": BASE.reshape(2, 3, 4)[:, ::-1],
    "flat": np.asfortranarray(BASE[:12].reshape(1, 3, 4)),
}


@pytest.mark.parametrize("layout", CUBES)
def test_a_constant_of_three_dimensions(layout: str) -> None:
    table = CUBES[layout]

    def program(o):
        for i in range(table.shape[0]):
            for j in range(table.shape[1]):
                for k in range(table.shape[2]):
                    o[(i * table.shape[1] + j) * table.shape[2] + k] = table[i, j, k]
        for j, v in enumerate(table[0, :, 1]):
            o[24 + j] = v

    kernel = KernelFunction(program, "void(int32[::1])", None)
    expected, found = np.zeros(32, np.int32), np.zeros(32, np.int32)
    kernel(expected)
    interpreted(Construct(kernel, (), False), (found,))
    np.testing.assert_array_equal(found, expected)


def powers(x, o):
    o[:] = np.power(x, 2)
    for i in range(len(x)):
        o[i] += np.power(x[i], 3)


def powers_in_place(x, o):
    x **= 2
    o[:] = x


def powers_of_powers(x, o):
    o[:] = np.power(x & 31, x & 5)


@pytest.mark.parametrize("kernel", [powers, powers_in_place, powers_of_powers])
@pytest.mark.filterwarnings("error")
def test_powers_of_integers_are_exact(kernel: Callable[..., None]) -> None:
    values = np.array([4097, -5, 46340, 0, 70000, 1, -1, 3], np.int32)
    program = KernelFunction(kernel, "void(int32[::1], int32[::1])", None)
    expected, found = (values.copy(), np.zeros(8, np.int32)), (values.copy(), np.zeros(8, np.int32))
    program(*expected)
    interpreted(Construct(program, (), False), found)
    np.testing.assert_array_equal(found, expected)


def in_place(x, y):
    x //= 3
    x %= 7
    x <<= 2
    x |= 1
    x ^= y
    x &= 0x7F
    x >>= 1
    x += y
    x -= 2
    x *= y


def test_operators_in_place() -> None:
    program = KernelFunction(in_place, "void(int32[::1], int32[::1])", None)
    x, y = np.arange(-9, 9, dtype=np.int32) * 1234567, np.arange(18, dtype=np.int32)
    expected, found = (x.copy(), y), (x.copy(), y)
    program(*expected)
    interpreted(Construct(program, (), False), found)
    np.testing.assert_array_equal(found[0], expected[0])


def returned_after_its_high_bits(i, j, out):
    out[0] = np.int32((i ^ j) >> np.uint64(31))
    return i ^ j


def test_a_wide_result_whose_shift_is_stored() -> None:
    program = KernelFunction(
        returned_after_its_high_bits, "uint64(uint64, uint64, int32[::1])", None
    )
    args = np.uint64(2**40 + 5), np.uint64(7)
    expected, found = np.zeros(1, np.int32), np.zeros(1, np.int32)
    value = program(*args, expected)
    assert interpreted(Construct(program, (), False), (*args, found)) == value == 2**40 + 2
    np.testing.assert_array_equal(found, expected)


THIRDS = np.array([1 / 3, -2 / 3, 4.0])


@pytest.mark.filterwarnings("ignore:.*float64 arithmetic runs in float32")
def test_elements_of_float64_are_rounded_with_a_warning() -> None:
    def program(x):
        for i in range(len(x)):
            x[i] = THIRDS[i % 3] * x[i]

    kernel = KernelFunction(program, "void(float32[::1])", None)
    mine, theirs = np.arange(7, dtype=np.float32), np.arange(7, dtype=np.float32)
    kernel(theirs)
    with pytest.warns(VividcWarning, match=r":\d+: a constant array of float64 is rounded"):
        run_regions(lower(kernel), [mine])
    np.testing.assert_allclose(mine, theirs, rtol=1e-6)
