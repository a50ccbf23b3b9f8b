"""Matrix products between other loops of a kernel, on an accelerator."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import vividc
from vividc import arch
from vividc.errors import SimulationError
from vividc.gemm.kernels.choice import explain
from vividc.program import Program, from_bytes

RNG = np.random.default_rng(7)

Matrix = NDArray[np.float32]


def random(*shape: int) -> Matrix:
    return RNG.standard_normal(shape).astype(np.float32)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def scores(a, b, c, d):
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            d[i, k] = max(a[i, k], np.float32(0))
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                c[i, j] += d[i, k] * b[k, j]
    for i in range(a.shape[0]):
        for j in range(1, c.shape[1]):
            c[i, j] += c[i, j - 1]


@pytest.fixture(scope="module")
def program() -> Program:
    return vividc.compile(
        scores, fabric="vivid", loops=vividc.LoopOptions(auto=False), effort="fast"
    )


def ran(program: Program, rows: int, inner: int, cols: int) -> None:
    """A launch equals numba, and its cycles add up."""
    arrays = [random(rows, inner), random(inner, cols), random(rows, cols), random(rows, inner)]
    numbas = [array.copy() for array in arrays]
    result = vividc.simulate(program, *arrays, fabric="vivid")
    scores(*numbas)
    for mine, numba in zip(arrays, numbas, strict=True):
        assert np.abs(mine - numba).max() <= 1e-4 * np.abs(numba).max()
    stats = result.stats
    assert stats["cycles"] == result.cycles == result.events[-1].end
    for tile in stats["tiles"]:
        assert sum(tile["cycles"].values()) + sum(tile["stalls"].values()) == result.cycles
    assert sum(tile["runs"] for tile in stats["tiles"]) == stats["runs"] == len(result.values)


def systolic(program: Program, rows: int, inner: int, cols: int) -> bool:
    """Whether some run is of the program of an array."""
    arrays = [random(rows, inner), random(inner, cols), random(rows, cols), random(rows, inner)]
    result = vividc.simulate(program, *arrays, fabric="vivid")
    return any(e.unit == "tile" and not e.program.startswith("scores") for e in result.events)


def test_a_large_product_runs_on_the_array(program: Program) -> None:
    assert [nest.products is not None for nest in program.nests] == [False, True, False]
    ran(program, 96, 48, 64)
    assert systolic(program, 96, 48, 64)


def test_a_small_one_stays_with_the_loops_around_it(program: Program) -> None:
    ran(program, 4, 3, 2)
    assert not systolic(program, 4, 3, 2)


def test_both_ways_give_the_same_bits_and_one_is_faster(program: Program) -> None:
    arrays = [random(96, 48), random(48, 64), random(96, 64), random(96, 48)]
    others = [array.copy() for array in arrays]
    fast = vividc.simulate(program, *arrays, fabric="vivid")
    loops = vividc.compile(
        scores, fabric="vivid", mode="gpu", loops=vividc.LoopOptions(auto=False), effort="fast"
    )
    assert not any(nest.products for nest in loops.nests)
    slow = vividc.simulate(loops, *others, fabric="vivid")
    assert fast.cycles < slow.cycles
    assert all(np.array_equal(a, b) for a, b in zip(arrays, others, strict=True))


def test_arrays_are_as_before_if_a_run_fails(program: Program) -> None:
    arrays = [random(96, 48), random(48, 64), random(96, 64), random(96, 48)]
    before = [array.copy() for array in arrays]
    with pytest.raises(SimulationError):
        vividc.simulate(program, *arrays, fabric="vivid", cycle_limit=200)
    assert all(np.array_equal(a, b) for a, b in zip(arrays, before, strict=True))


def test_it_travels_in_the_bundle_and_is_explained(program: Program) -> None:
    assert from_bytes(program.to_bytes()) == program
    text = explain(program, arch.load_accelerator("vivid"))
    assert "matrix product c = d b + c: 4096x64 by 64x64: mode tpu" in text
    assert "test_product_nests.py:29" in text


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1])")
def centred(a, c, mean):
    """Columns first: they fit a scratchpad as boxes, and not as one axis of words, as the product
    would have them.
    """
    for j in range(a.shape[1]):
        mean[j] = np.float32(0)
        for i in range(a.shape[0]):
            mean[j] += a[i, j]
    for i in range(c.shape[0]):
        for j in range(i, c.shape[0]):
            c[i, j] = np.float32(0)
            for k in range(a.shape[0]):
                c[i, j] += a[k, i] * a[k, j]
            c[j, i] = c[i, j]


@pytest.mark.slow
def test_loops_beside_a_product_go_through_boxes_of_their_own() -> None:
    program = vividc.compile(
        centred, fabric="vivid", loops=vividc.LoopOptions(auto=False), effort="fast"
    )
    assert [nest.products is not None for nest in program.nests] == [False, True]
    arrays = [random(120, 96), random(96, 96), random(96)]
    numbas = [array.copy() for array in arrays]
    vividc.simulate(program, *arrays, fabric="vivid")
    centred(*numbas)
    for mine, numba in zip(arrays, numbas, strict=True):
        assert np.abs(mine - numba).max() <= 1e-4 * np.abs(numba).max()
