"""What a kernel raises ends its run on both engines, with the same words at the same cycle."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.sim.native.agreement import assert_engines_agree, launch
from vividc.errors import SimulationError
from vividc.program import Program


@vividc.kernel("float32(float32[:, ::1])")
def sum_of_largest(x):
    total = np.float32(0.0)
    for i in range(x.shape[0]):
        total += x[i].max()
    return total


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def shift_and_add(x, y, n):
    x[n:] = x[n:] + y


@pytest.fixture(scope="module", params=[sum_of_largest, shift_and_add])
def program(request: pytest.FixtureRequest) -> Program:
    return vividc.compile(request.param, loops=vividc.LoopOptions(auto=False), time_limit_s=20)


def arguments(program: Program, size: int) -> tuple[object, ...]:
    if program.name == "sum_of_largest":
        return (np.arange(3 * size, dtype=np.float32).reshape(3, size),)
    return np.arange(8, dtype=np.int32), np.arange(size, dtype=np.int32), 3


def test_engines_agree_on_what_is_raised(program: Program) -> None:
    assert_engines_agree(program, *(launch(program, *arguments(program, n)) for n in range(9)))


@pytest.mark.parametrize("limit", range(0, 40, 5))
def test_engines_agree_on_what_comes_first(program: Program, limit: int) -> None:
    given = launch(program, *arguments(program, 0), cycle_limit=limit)
    assert_engines_agree(program, given)


@pytest.mark.parametrize("engine", ["reference", "native", "auto"])
def test_a_simulation_says_what_is_raised(program: Program, engine: str) -> None:
    with pytest.raises(SimulationError, match="the kernel raises ValueError"):
        vividc.simulate(program, *arguments(program, 0), engine=engine)


@pytest.mark.parametrize("spare", [0, 3, 6, 9])
def test_engines_agree_where_the_scratchpad_is_full(spare: int) -> None:
    program = vividc.compile(shift_and_add, loops=vividc.LoopOptions(auto=False), time_limit_s=20)
    words = program.fabric.scratchpad.words - spare
    x, y = np.zeros((2, words // 3), np.int32)  # and x[n:] + y is as large
    assert_engines_agree(program, launch(program, x, y, x.size - 2))
    with pytest.raises(SimulationError, match="the kernel raises ValueError"):
        vividc.simulate(program, x, y, x.size - 2)
