"""Addresses that are affine in the iteration: what they cost, and in which order they are kept."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import run_regions
from vividc import arch
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.ir import DFG
from vividc.dfg.pipeline import optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.machine.opcodes import LatencyClass
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.problem import MapProblem

TWO = np.float32(2.0)
ARRAYS = "void(float32[::1], float32[::1])"


@vividc.kernel(ARRAYS)
def one_stride(x, y):
    for i in range(33):
        x[3 * i] *= TWO
        x[3 * i + 1] += x[3 * i + 2]
        y[3 * i] = x[3 * i + 2] * TWO
        y[6 * i + 1] = TWO


@vividc.kernel(ARRAYS)
def backwards(x, y):
    for i in range(len(x) - 1, -1, -1):
        x[i] = x[i] * TWO
        y[i] = x[i]


@vividc.kernel(ARRAYS)
def by_a_step(x, y):
    for i in range(5, len(x) - 1, 7):
        x[i] = x[i + 1] * TWO
        y[i - 5] = TWO


@vividc.kernel(ARRAYS)
def towards_each_other(x, y):
    for i in range(50):
        x[i] = x[99 - i] + y[98 - 2 * i]


@vividc.kernel(ARRAYS)
def three_back(x, y):
    for i in range(90, 2, -1):
        x[i] = x[i + 3] * TWO
        y[i] = y[i - 3] + x[i]


@vividc.kernel(ARRAYS)
def two_counters(x, y):
    for i in range(1, 30):
        x[3 * i] = x[3 * (i - 1)] + y[3 * i]
        y[5 * i] = x[5 * i - 1]


@vividc.kernel("void(float32[:,::1], float32[:,::1])")
def columns(x, y):
    for i in range(x.shape[0] - 1):
        y[0, i] = x[i, 2] + x[i + 1, 3] * x[i, 1]


@vividc.kernel("void(float32[::1], float32[::1], int32, int32)")
def strides_of_arguments(x, y, n, m):
    for i in range(20):
        x[i * n] = y[2 * i * n + 1] + x[i * m]
        y[i * n] = TWO


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def by_an_argument(x, y, n):
    if n < 1:
        return
    for i in range(3, 100, n):
        x[i] = y[i + 1] * TWO


@vividc.kernel("void(float32[::1], float32[::1], uint32, uint32)")
def named_as_symbols_are(x, y, iteration, inner):
    for i in range(20):
        x[np.uint32(i) + iteration] = y[np.uint32(3 * i) + inner]


KERNELS = [one_stride, backwards, by_a_step, towards_each_other, three_back, two_counters]


def regions(kernel: Any) -> Kernel:
    return optimize_kernel(build_kernel(kernel.lower()))


def loop(kernel: Any) -> DFG:
    (dfg,) = (region.dfg for region in regions(kernel).regions if region.kind == "loop")
    return dfg


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.name)
def test_loops_compute_what_numba_does(kernel: Callable[..., object]) -> None:
    rng = np.random.default_rng(1)
    by_graph = [rng.standard_normal(210).astype(np.float32) for _ in range(2)]
    by_numba = deepcopy(by_graph)
    run_regions(regions(kernel), by_graph)
    kernel(*by_numba)
    for ours, theirs in zip(by_graph, by_numba, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


@pytest.mark.parametrize(
    ("kernel", "others"),
    [
        (columns, ()),
        (strides_of_arguments, (np.int32(3), np.int32(5))),
        (by_an_argument, (np.int32(7),)),
        (named_as_symbols_are, (np.uint32(3), np.uint32(5))),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_strides_that_a_launch_tells(kernel: Any, others: tuple[np.int32, ...]) -> None:
    rng = np.random.default_rng(2)
    shape = (20, 20) if kernel is columns else (400,)
    by_graph = [rng.standard_normal(shape).astype(np.float32) for _ in range(2)]
    by_numba = deepcopy(by_graph)
    run_regions(regions(kernel), [*by_graph, *others])
    kernel(*by_numba, *others)
    for ours, theirs in zip(by_graph, by_numba, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


@pytest.mark.parametrize(
    ("kernel", "additions"),
    [
        *(
            (one_stride, 1),
            (backwards, 1),
            (by_a_step, 1),
            (towards_each_other, 1),
            (three_back, 1),
        ),
        (columns, 1),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_a_stride_costs_one_addition(kernel: Any, additions: int) -> None:
    classes = [node.latency_class for node in loop(kernel).operations]
    assert classes.count(LatencyClass.INT) == additions
    assert LatencyClass.IMUL not in classes


@pytest.mark.parametrize(
    ("kernel", "ii"),
    [(one_stride, 2), (backwards, 1), (by_a_step, 1), (three_back, 3)],
    ids=lambda item: getattr(item, "name", ""),
)
def test_only_real_dependences_bind(kernel: Any, ii: int) -> None:
    assert mii(all_bounds(MapProblem(loop(kernel), arch.load("vivid-tile")))) == ii


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def two_ahead(x, y, n):
    for i in range(n):
        y[i] = x[i + 2] + x[i]


def test_subscripts_that_might_be_negative_are_expected_not_to_be() -> None:
    """Where the end is added to a negative one, banks are chosen for those that are not."""
    x = np.arange(42, dtype=np.float32)
    y = np.zeros(40, np.float32)
    result = vividc.simulate(vividc.compile(two_ahead), x, y, np.int32(40))
    assert np.array_equal(y, x[2:] + x[:-2])
    assert result.stats["stalls"]["bank_conflict"] == 0
