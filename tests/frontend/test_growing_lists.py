"""Lists that grow and shrink: elements, lengths and errors are those of numba's lists."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.frontend.growing_kernels import GROWING
from tests.fuzz.witnesses import words_in_blocks
from vividc.errors import ArgumentError, KernelError, VividcWarning
from vividc.program import Program, from_bytes

SIGNATURE = "(float32[::1], int32[::1], int32)"


def _program(function: Callable[..., object]) -> Program:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        lowered = vividc.kernel(SIGNATURE)(function).lower()
    return from_bytes(words_in_blocks(lowered).to_bytes())


def _inputs() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    x = rng.standard_normal(16).astype(np.float32)
    return x, rng.integers(-6, 6, 16).astype(np.int32)


@pytest.mark.parametrize("function", GROWING)
def test_lists_are_numbas(function: Callable[..., object]) -> None:
    program = _program(function)
    kernel = vividc.kernel(SIGNATURE)(function)
    x, a = _inputs()
    for n in (2, 3):
        expected = kernel(x.copy(), a.copy(), np.int32(n))
        found = vividc.simulate(program, x.copy(), a.copy(), n).value
        whole = expected if isinstance(expected, tuple) else (expected,)
        mine = found if isinstance(found, tuple) else (found,)
        for one, other in zip(mine, whole, strict=True):
            assert isinstance(one, list) is isinstance(other, list)
            np.testing.assert_allclose(one, other, rtol=1e-5)


def taken(x, a, n):
    out = [v for v in x if v > 0]
    return out[n]


def popped(x, a, n):
    out = [v for v in x if v > 0]
    for _ in range(n):
        out.pop()
    return len(out)


def missed(x, a, n):
    out = [v for v in a if v > 0]
    return out.index(n)


@pytest.mark.parametrize(
    ("function", "kind", "text"),
    [
        (taken, IndexError, "getitem out of range"),
        (popped, IndexError, "pop from empty list"),
        (missed, ValueError, "value not in list"),
    ],
)
def test_errors_are_numbas(
    function: Callable[..., object], kind: type[Exception], text: str
) -> None:
    kernel = vividc.kernel(SIGNATURE)(function)
    program = _program(function)
    x, a = _inputs()
    with pytest.raises(kind, match=text):
        kernel(x, a, np.int32(100))
    with pytest.raises(kind, match=text):
        vividc.simulate(program, x, a, 100)


def test_a_list_that_nothing_bounds_ends_with_an_error() -> None:
    def endless(x, a, n):
        out = []
        k = 0
        while k < n:
            out.append(k)
            k += 1 + a[0] * 0
        return len(out)

    program = _program(endless)
    x, a = _inputs()
    assert vividc.simulate(program, x, a, 1024).value == 1024
    with pytest.raises(MemoryError, match="a list of more than 1024 elements"):
        vividc.simulate(program, x, a, 1025)


def test_a_list_has_the_length_that_a_launch_bounds() -> None:
    def evens(x, a, n):
        out = []
        for i in range(len(a)):
            if a[i] % 2 == 0:
                out.append(a[i])
        return len(out)

    program = _program(evens)
    a = np.zeros(4000, np.int32)
    assert vividc.simulate(program, np.zeros(1, np.float32), a, 0).value == 4000
    with pytest.raises(ArgumentError, match="scratchpad"):
        vividc.simulate(program, np.zeros(1, np.float32), np.zeros(5000, np.int32), 0)


def handed_on(x, a, n):
    path = [x[0]]
    for i in range(n):
        path = path + [x[i]]  # noqa: RUF005 - a sum is what is tested
    x[0] = path[-1]


def exchanged(x, a, n):
    now = [x[0]]
    for _ in range(n):
        following = [v + 1 for v in now if v > 0]  # here
        now = following
    x[0] = len(now)


def of_arrays(x, a, n):
    parts = []  # here
    for i in range(n):
        parts.append(x[i:])
    x[0] = len(parts)


def of_lists(x, a, n):
    rows = [[1, 2], [n, 4]]  # here
    rows.append([5, 6])
    x[0] = rows[0][1]


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (handed_on, "a list that an iteration makes is there in the next one"),
        (exchanged, "a list that an iteration makes is there in the next one"),
        (of_arrays, "a list of arrays"),
        (of_lists, "a list of lists"),
    ],
)
def test_what_the_array_has_no_place_for_is_refused(
    function: Callable[..., object], text: str
) -> None:
    with pytest.raises(KernelError, match=re.escape(text)) as caught:
        vividc.kernel(SIGNATURE)(function).lower()
    assert caught.value.hint


@pytest.mark.parametrize("kind", ["int32", "float32"])
def test_equal_elements_are_ordered_as_numba_does(kind: str) -> None:
    def order(x):
        return np.argsort(x)

    kernel = vividc.kernel(f"({kind}[::1],)")(order)
    program = words_in_blocks(kernel.lower())
    rng = np.random.default_rng(0)
    for size in (0, 1, 2, 5, 15, 16, 17, 31, 60):
        x = rng.integers(0, max(size // 3, 2), size).astype(kind)
        if kind == "float32":
            x[rng.random(size) < 0.2] = np.nan
        np.testing.assert_array_equal(vividc.simulate(program, x).value, kernel(x))


def test_a_sort_by_a_key_keeps_numbas_order_of_equal_keys() -> None:
    def by_key(x, a, n):
        out = [(v % 3, v) for v in a]
        out.sort()
        return [k for k, _ in out], [v for _, v in out]

    program = _program(by_key)
    x, a = _inputs()
    assert vividc.simulate(program, x, a, 0).value == vividc.kernel(SIGNATURE)(by_key)(
        x, a, np.int32(0)
    )
