"""When the compiler flattens a nest: where the estimate says so, and where the user does."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

import vividc
from benchmarks.general import WORKLOADS
from tests.e2e import nest_kernels


def line_of(kernel: vividc.KernelFunction, text: str) -> int:
    """The first line of the kernel's source that contains `text`."""
    lines, start = inspect.getsourcelines(kernel.py_func)
    return start + next(number for number, line in enumerate(lines) if text in line)


def kinds(program: vividc.Program) -> list[str]:
    """The transformations that the program has."""
    return [t.kind for loop in program.loops for t in loop.transforms if not t.reason]


@vividc.kernel("void(int32[::1], int32[::1], float32[::1], float32[::1], float32[::1])")
def rows_anywhere(row_start, column, value, x, y):
    """Sums of a sparse matrix's rows, which may meet in `y`, of what takes long to compute: a row
    by itself would hide little of it.
    """
    for i in range(len(row_start) - 1):
        total = np.float32(0.0)
        for k in range(row_start[i], row_start[i + 1]):
            v = value[k] * x[column[k]]
            v = v * v + np.float32(1.0)
            v = v * v + value[k]
            total += v
        y[column[i] & 7] = total


def test_short_rows_are_flattened() -> None:
    """Bounds that are loaded are taken to be near each other."""
    workload = next(w for w in WORKLOADS if w.name == "spmv_csr")
    kernel = rows_anywhere
    program = vividc.compile(kernel)
    assert kinds(program) == ["flattening"]
    outcomes = [loop.outcome for loop in program.loops]
    assert outcomes[1] == "flattened: one loop with the loop inside it"
    by_array, by_numba = workload.fresh(), workload.fresh()
    cycles = vividc.simulate(program, *by_array).cycles
    kernel(*by_numba)
    for mine, theirs in zip(by_array, by_numba, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-4, atol=1e-5)
    plain = vividc.compile(kernel, loops=vividc.LoopOptions(auto=False))
    assert cycles < vividc.simulate(plain, *workload.fresh()).cycles


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def much_around(a, start, w):
    """A loop in the midst of operations that one loop would have in each of its iterations."""
    for i in range(a.shape[0]):
        total = a[i]
        for n in range(40):
            total ^= ((a[i] >> (n & 7)) + n) * (a[i] | n)
        for k in range(start[i], start[i + 1]):
            w[(k + 2) & 15] += total
        a[i] = total


def test_a_nest_with_much_around_its_loop_is_not_even_flattened() -> None:
    program = vividc.compile(much_around)
    tried = [one for loop in program.loops for one in loop.transforms if one.kind == "flattening"]
    assert [one.chosen for one in tried] == [False]
    assert tried[0].reason.startswith("one loop would have")


def test_the_user_decides() -> None:
    kernel = nest_kernels.stairs
    line = line_of(kernel, "for i")
    assert kinds(
        vividc.compile(kernel, loops=vividc.LoopOptions(auto=False, flatten={line: True}))
    ) == ["flattening"]
    assert "flattening" not in kinds(
        vividc.compile(kernel, loops=vividc.LoopOptions(flatten={line: False}))
    )


def test_a_nest_that_is_none_is_refused() -> None:
    kernel = nest_kernels.stairs
    with pytest.raises(vividc.VividcError, match="flattening is not possible here: it does not"):
        vividc.compile(kernel, loops=vividc.LoopOptions(flatten={line_of(kernel, "for j"): True}))


@pytest.mark.parametrize("flatten", [{12: 3}, {0: True}, {"x": True}, [12]])
def test_odd_choices_are_refused(flatten: object) -> None:
    with pytest.raises(vividc.VividcError, match="flatten"):
        vividc.compile(nest_kernels.stairs, loops=vividc.LoopOptions(flatten=flatten))  # type: ignore[arg-type]
