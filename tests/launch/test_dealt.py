"""Chunks go to the tiles that are done with them first: cycles are predicted, and are fewer than on
any number of tiles in turn; results are the same bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from tests.fuzz.witnesses import words_in_blocks
from vividc.frontend import KernelFunction as Kernel
from vividc.launch import SpreadOptions, spread
from vividc.launch.tiles.dealt import Costs, dealt
from vividc.program import Program
from vividc.ssa.parallel.cut import cut_parallel_loop

RNG = np.random.default_rng(2)


@vividc.kernel("float32[:, :, ::1](int32, int32)")
def shaded(h, w):
    image = np.zeros((h, w, 3), np.float32)
    for y in prange(h):
        for x in range(w):
            image[y, x, 0] = np.float32(x) * np.float32(y)
            image[y, x, 1] = np.float32(x) + np.float32(y)
            image[y, x, 2] = np.float32(1)
    return image


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def added(x, y):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i, j] * np.float32(3) + y[i, j]


@vividc.kernel("float32(float32[:, ::1])")
def total(x):
    found = np.float32(0)
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            found += x[i, j]
    return found


@vividc.kernel("void(int32[:, ::1], int32)")
def escapes(counts, most):
    for i in prange(counts.shape[0]):
        for j in range(counts.shape[1]):
            n = 0
            z = (i - 20) * (j - 10)
            while n < most and abs(z) < 100:
                z = z * 3 // 2 + 1
                n += 1
            counts[i, j] = n


def matrix(height: int, width: int = 40) -> np.ndarray:
    return RNG.random((height, width), dtype=np.float32)


CASES: list[tuple[Kernel, Callable[[], tuple[Any, ...]]]] = [
    (shaded, lambda: (np.int32(64), np.int32(40))),
    (shaded, lambda: (np.int32(4), np.int32(8))),
    (added, lambda: (matrix(20), matrix(20))),
    (added, lambda: (matrix(200), matrix(200))),
    (total, lambda: (matrix(33),)),
    (total, lambda: (matrix(128),)),
    (escapes, lambda: (np.zeros((36, 20), np.int32), np.int32(15))),
]


@pytest.fixture(scope="module")
def programs() -> Callable[[Kernel], Program]:
    made: dict[str, Program] = {}

    def program(kernel: Kernel) -> Program:
        if kernel.name not in made:
            function, parallel = cut_parallel_loop(kernel.lower(spread=True), kernel.prange_lines)
            made[kernel.name] = replace(words_in_blocks(function), parallel=parallel)
        return made[kernel.name]

    return program


@pytest.mark.parametrize("number", range(len(CASES)))
def test_a_launch_takes_the_tiles_that_are_predicted_to_be_fastest(
    number: int, programs: Callable[[Kernel], Program]
) -> None:
    kernel, make = CASES[number]
    given, cycles, left = make(), {}, []
    for tiles in (1, 2, 4, 16, None):
        args = [arg.copy() if isinstance(arg, np.ndarray) else arg for arg in given]
        launch = spread(programs(kernel), args, {}, "vivid", SpreadOptions(tiles=tiles))
        result = launch.simulate()
        cycles[tiles] = result.cycles
        left.append([*args, result.value])
        if tiles is None:
            assert launch.predicted is not None
            tolerance = 0.25 if kernel is escapes else 0.12
            assert math.isclose(launch.predicted, result.cycles, rel_tol=tolerance)
        else:
            assert launch.predicted is None
            assert len(result.stats["tiles"]) == min(tiles, len(launch.plan.chunks))
    assert cycles.pop(None) <= 1.02 * min(cycles.values())
    for other in left:
        for one, mine in zip(left[0], other, strict=True):
            np.testing.assert_array_equal(one, mine)


def test_a_tile_that_is_configured_late_gets_less_or_nothing() -> None:
    costs = Costs(100, 50, [1] * 12, [1] * 12, 5, 5, 0)
    few = dealt(costs, 2, 16).tiles
    assert max(few) < 5
    assert few.count(0) > few.count(max(few))
    assert set(dealt(replace(costs, run=5000), 2, 16).tiles) == set(range(12))


def test_transfers_that_take_longer_than_runs_bound_a_launch() -> None:
    costs = Costs(1, 5, [1000] * 8, [500] * 8, 20, 20, 300)
    assert dealt(costs, 2, 16).cycles >= 8 * 1500 + 300
