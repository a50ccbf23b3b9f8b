"""Arrays of a kernel's own in the bundle, in the scratchpad, and under the simulator's checks."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.errors import ArgumentError, CycleLimit, KernelError, SimulationError
from vividc.frontend import KernelFunction
from vividc.program import Program

TABLE = np.array([3, 1, 4, 1], np.int32)


def counts(x, n):
    seen = np.zeros(4, np.int32)
    for i in range(n):
        seen[x[i]] += TABLE[i & 3]
    for i in range(4):
        x[i] = seen[i]


def large(x, n):
    a = np.zeros(9000, np.int32)
    a[n] = 1
    x[0] = a[n + 1]


def searches(x, n):
    i = 0
    while x[i] != n:
        i = (i + 1) & 3
    x[0] = i


def compiled(function: object) -> Program:
    kernel = KernelFunction(function, "void(int32[::1], int32)", None)  # type: ignore[arg-type]
    return vividc.compile(kernel, time_limit_s=20.0, effort="fast")


@pytest.fixture(scope="module")
def program() -> Program:
    return compiled(counts)


def test_the_bundle_holds_the_tables(program: Program, tmp_path) -> None:
    program.save(tmp_path / "p.vivid")
    loaded = vividc.load(tmp_path / "p.vivid")
    assert loaded == program
    assert [local.words for local in loaded.locals] == [4, 4]
    assert [local.contents for local in loaded.locals] == [None, (3, 1, 4, 1)]
    x = np.array([0, 1, 2, 3, 0, 0], np.int32)
    vividc.simulate(loaded, x, 6)
    assert x.tolist() == [3 + 3 + 1, 1, 4, 1, 0, 0]


def test_every_launch_starts_afresh(program: Program) -> None:
    results = []
    for _ in range(2):
        x = np.zeros(8, np.int32)
        vividc.simulate(program, x, 8)
        results.append(x.tolist())
    assert results[0] == results[1]


@pytest.mark.parametrize("index", [4, 100, -5])
def test_an_index_outside_an_array_of_the_kernels_own_is_an_error(
    program: Program, index: int
) -> None:
    with pytest.raises(SimulationError, match="local0"):
        vividc.simulate(program, np.full(4, index, np.int32), 1)


def test_arguments_and_own_arrays_share_the_scratchpad(program: Program) -> None:
    vividc.simulate(program, np.zeros(8192 - 8, np.int32), 1)
    with pytest.raises(ArgumentError, match="the scratchpad has"):
        vividc.simulate(program, np.zeros(8192 - 7, np.int32), 1)


def test_own_arrays_that_never_fit_are_refused_when_compiled() -> None:
    with pytest.raises(KernelError, match="36000 bytes"):
        compiled(large)


def test_an_endless_run_is_given_up() -> None:
    with pytest.raises(CycleLimit, match="after 500 cycles") as caught:
        vividc.simulate(compiled(searches), np.zeros(4, np.int32), 7, cycle_limit=500)
    assert caught.value.exit_code == 4
    assert "never ends" in str(caught.value.hint)
