"""`np.triu` and `np.tril` keep the elements that numpy's keep, for every diagonal and element."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.ssa.interpret import interpret


def triangles(a, k, upper, lower):
    upper[:] = np.triu(a, k)
    lower[:] = np.tril(a, k=k)


def defaults(a, upper, lower):
    upper[:] = np.triu(a)
    lower[:] = np.tril(a, -1)


def above(a):
    return np.triu(a)


@pytest.mark.parametrize("dtype", ["float32", "bool", "complex64"])
def test_every_diagonal(dtype: str) -> None:
    array = f"{'boolean' if dtype == 'bool' else dtype}[:, ::1]"
    lowered = vividc.kernel(f"({array}, int32, {array}, {array})")(triangles).lower()
    for shape in ((4, 6), (5, 3), (0, 2)):
        drawn = np.random.default_rng(0).integers(-9, 9, shape)
        a = (drawn * (1 + 2j) if dtype == "complex64" else drawn).astype(dtype)
        for k in range(-6, 8):
            upper, lower = np.ones_like(a), np.ones_like(a)
            interpret(lowered, a, np.int32(k), upper, lower)
            assert upper.tobytes() == np.triu(a, k).tobytes(), (shape, k)
            assert lower.tobytes() == np.tril(a, k).tobytes(), (shape, k)


def test_defaults() -> None:
    a = np.arange(-6, 6, dtype=np.int32).reshape(3, 4)
    upper, lower = np.ones_like(a), np.ones_like(a)
    kernel = vividc.kernel("(int32[:, ::1], int32[:, ::1], int32[:, ::1])")(defaults)
    interpret(kernel.lower(), a, upper, lower)
    assert np.array_equal(upper, np.triu(a))
    assert np.array_equal(lower, np.tril(a, -1))


def test_a_triangle_keeps_no_mask() -> None:
    kernel = vividc.kernel("float32[:, ::1](float32[:, ::1])")(above)
    assert len(vividc.compile(kernel, loops=vividc.LoopOptions(auto=False)).locals) == 0
