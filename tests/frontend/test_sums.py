"""`np.sum` along an axis of a matrix adds what numpy's adds, in numba's order."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import vividc
from vividc.ssa.interpret import interpret


def along_axes(a, columns, rows, last, first):
    columns[:] = np.sum(a, axis=0)
    rows[:] = np.sum(a, 1)
    last[:] = np.sum(a, axis=-1)
    first[:] = np.sum(a, axis=-2)


def of_columns(a):
    return np.sum(a, axis=0)


def test_the_order_is_numbas() -> None:
    vector = "float32[::1]"
    kernel = vividc.kernel(f"(float32[:, ::1], {vector}, {vector}, {vector}, {vector})")(along_axes)
    lowered, compiled = kernel.lower(), numba.njit(along_axes)
    for shape in ((5, 7), (3, 0), (0, 2)):
        a = np.random.default_rng(0).normal(size=shape).astype(np.float32) * 1e3
        found, expected = (
            [np.ones(length, np.float32) for length in (*shape[::-1], *shape)] for _ in range(2)
        )
        interpret(lowered, a, *found)
        compiled(a, *expected)
        assert [one.tobytes() for one in found] == [one.tobytes() for one in expected]


@pytest.mark.parametrize("dtype", ["int32", "complex64"])
def test_other_elements_are_numbas(dtype: str) -> None:
    a = np.arange(-6, 6).reshape(3, 4).astype(dtype)
    kind = "int64" if dtype == "int32" else dtype
    kernel = vividc.kernel(f"{kind}[::1]({dtype}[:, ::1])")(of_columns)
    assert kernel.lower().params[0].name == "a"
    assert np.array_equal(kernel(a), a.sum(axis=0))


def test_a_column_is_summed_in_a_register() -> None:
    kernel = vividc.kernel("float32[::1](float32[:, ::1])")(of_columns)
    program = vividc.compile(kernel, loops=vividc.LoopOptions(auto=False))
    assert len(program.locals) == 0
    assert len([region for region in program.regions if region.kind == "loop"]) == 1
