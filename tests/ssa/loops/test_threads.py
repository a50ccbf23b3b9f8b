"""Iterations of a parallel loop as threads: the words of one after the other, shared loads, and
what is refused.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from benchmarks.workloads import Workload
from tests.fuzz.threads import threaded
from tests.fuzz.witnesses import run_regions
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.ir import DFG, Control
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.errors import KernelError
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import Opcode
from vividc.ssa.check import check_function
from vividc.ssa.ir import Function
from vividc.ssa.loops.threads.make import thread
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

PLAIN = PassOptions(contract=False)


def run(function: Function, header: str, count: str) -> object:
    done = thread(function, header, int(count))
    if isinstance(done, Refusal):
        return done.reason
    loops = (f"{new} was {old}" for new, old in done.loops)
    return done.function, f"main {done.main}", *loops


@cases(__file__)
def test_rules(case: Case) -> None:
    """What is spread runs from inputs that only a launch supplies."""
    FUNCTIONS.check(case, run, same="prange" not in case.before)


def made(kernel: KernelFunction, count: int) -> Function:
    function = threaded(kernel, count)
    assert isinstance(function, Function), function
    assert check_function(function) == []
    return function


def agree(kernel: KernelFunction, count: int, *args: Any) -> None:
    """Demands numba's words of a kernel with threads, and of the kernel as written."""
    expected = list(deepcopy(args))
    value = kernel(*expected)
    function = made(kernel, count)
    for form in (kernel.lower(), function, tidy(function)):
        mine = list(deepcopy(args))
        result = run_regions(optimize_kernel(build_kernel(normalize(form)), PLAIN), mine)
        assert result == value
        for found, wanted in zip(mine, expected, strict=True):
            np.testing.assert_array_equal(found, wanted)


def hot(kernel: KernelFunction, count: int, options: PassOptions = PLAIN) -> DFG:
    """The graph of the innermost loop."""
    regions = optimize_kernel(build_kernel(normalize(tidy(made(kernel, count)))), options).regions
    loops = [region.dfg for region in regions if region.kind == "loop"]
    return max(loops, key=lambda dfg: len(dfg.operations))


def blend() -> KernelFunction:
    kernel = Workload("gs_blend_rows", lambda rng: (), "threads").kernel()
    assert isinstance(kernel, KernelFunction)
    return kernel


def blend_arguments(rows: int) -> list[Any]:
    rng = np.random.default_rng(rows)
    count = 30

    def draw(low: float, high: float) -> Any:
        return rng.uniform(low, high, count).astype(np.float32)

    splats = [draw(0, 5), draw(0, 5), draw(0.05, 0.4), draw(-0.02, 0.02), draw(0.05, 0.4)]
    splats += [draw(0.4, 1.0), draw(0, 1), draw(0, 1), draw(0, 1)]
    out = np.zeros(4 * rows * 3, np.float32)
    return [*splats, out, *(np.int32(v) for v in (0, 0, 3, rows, count))]


@pytest.mark.parametrize(("count", "rows"), [(4, 8), (4, 5), (3, 4), (2, 1), (8, 3)])
def test_the_blend_keeps_its_bits(count: int, rows: int) -> None:
    kernel, words = blend(), []
    function = made(kernel, count)
    for form in (kernel.lower(), tidy(function)):
        mine = blend_arguments(rows)
        run_regions(optimize_kernel(build_kernel(normalize(form)), PLAIN), mine)
        words.append(mine[9].tobytes())
    assert words[0] == words[1]
    expected = blend_arguments(rows)
    kernel(*expected)
    np.testing.assert_allclose(np.frombuffer(words[1], np.float32), expected[9], atol=1e-6)


def test_four_threads_of_the_blend_share_the_splat_and_have_one_exit() -> None:
    graph = hot(blend(), 4)
    loads = [node for node in graph.nodes if node.op is Opcode.LOAD]
    assert len(loads) == 9
    assert all(load.lane is None for load in loads)
    assert sum(node.control is Control.EXIT for node in graph.nodes) == 1
    assert sum(node.op is Opcode.LIVE_OUT for node in graph.nodes) == 16


def test_copies_of_an_operation_are_twins() -> None:
    graph = hot(blend(), 4)
    lanes = [node.lane for node in graph.operations if node.op is Opcode.FMIN]
    assert len(lanes) == 8  # the clamp, and one in exp
    known = [lane for lane in lanes if lane is not None]
    assert len(known) == 8
    twins: dict[tuple[int, int], set[int]] = {}
    for lane in known:
        twins.setdefault((lane.origin, lane.part), set()).add(lane.thread)
    assert list(twins.values()) == [{0, 1, 2, 3}] * 2


@vividc.kernel("int32(int32[::1], int32[::1], int32)")
def sentinels(x, counts, n):
    """Each thread stops at a 0, the last one of all at the array's end."""
    total = np.int32(0)
    for i in prange(n):
        k = i
        while x[k] != 0:
            k += 1
        counts[i] = k - i
        total += np.int32(k)
    return total


@pytest.mark.parametrize("count", [2, 4, 8])
@pytest.mark.parametrize("n", [0, 1, 7, 8])
def test_a_thread_that_is_done_reads_nothing_beyond_its_array(count: int, n: int) -> None:
    x = np.array([3, 0, 2, 5, 0, 7, 1, 4, 0], np.int32)
    agree(sentinels, count, x, np.zeros(8, np.int32), np.int32(n))


@vividc.kernel("void(int32[::1], int32[::1], int32[::1])")
def first_match(x, keys, places):
    for i in prange(len(keys)):
        found = np.int32(-1)
        for k in range(len(x)):
            if x[k] == keys[i]:
                found = np.int32(k)
                break
        places[i] = found


def test_threads_leave_a_loop_by_different_exits_to_one_place() -> None:
    x = np.array([4, 8, 15, 16, 23, 42], np.int32)
    keys = np.array([15, 99, 4, 42, -1, 8, 8], np.int32)
    agree(first_match, 4, x, keys, np.zeros(7, np.int32))


@vividc.kernel("float32(float32[::1], float32[:, ::1])")
def handed_on(scale, x):
    total = np.float32(0.25)
    for i in prange(x.shape[0]):
        s = np.float32(0)
        for j in range(x.shape[1]):
            s += x[i, j] * scale[j]
        if s > np.float32(0.1):
            total += s
    return total


@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_sum_over_iterations_keeps_its_order(count: int) -> None:
    rng = np.random.default_rng(3)
    x = rng.standard_normal((11, 5)).astype(np.float32)
    agree(handed_on, count, rng.standard_normal(5).astype(np.float32), x)


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def own_array(x, y, n):
    for i in prange(n):
        t = np.empty(4, np.int32)
        for k in range(4):
            t[k] = x[i] * k
        for k in range(3):
            t[k + 1] += t[k]
        y[i] = t[3]


def test_each_thread_has_an_array_that_an_iteration_makes() -> None:
    rng = np.random.default_rng(1)
    agree(own_array, 4, rng.integers(0, 99, 6, np.int32), np.zeros(6, np.int32), np.int32(6))
    assert len(made(own_array, 4).locals) == 4


@vividc.kernel("void(int32[::1], int32[:, ::1], int32)")
def nested(x, y, m):
    for i in prange(y.shape[0]):
        a = x[i]
        for _ in range(a & 3):
            k = np.int32(0)
            while k < m:
                if (k + a) & 7 == 5:
                    break
                a = np.int32(a + x[k])
                k += 1
            if a > 60:
                break
        else:
            a = np.int32(a + 1000)
        y[i, 0] = a


def test_nested_loops_of_different_lengths() -> None:
    x = np.random.default_rng(5).integers(0, 12, 9).astype(np.int32)
    agree(nested, 4, x, np.zeros((9, 2), np.int32), np.int32(5))


@vividc.kernel("void(int32[::1], int32)")
def serial(x, n):
    before = np.int32(1)
    for i in prange(n):
        for _ in range(3):
            before = np.int32(before * 3 + x[i])
        x[i] = before


@vividc.kernel("int32(int32[::1])")
def last_index(x):
    last = 0
    for i in prange(len(x)):
        x[i] = 1
        last = 2 * i
    return np.int32(last)


def test_what_one_iteration_leaves_to_the_next_is_refused() -> None:
    refused = threaded(serial, 4)
    assert isinstance(refused, Refusal)
    assert "needs what the one before computed" in refused.reason
    with pytest.raises(KernelError, match=r"as threads is not possible") as caught:
        vividc.compile(serial, loops=vividc.LoopOptions(threads=4))
    assert caught.value.loc is not None
    assert caught.value.loc.line in serial.prange_lines


def test_a_variable_that_iterations_replace_is_the_last_ones() -> None:
    agree(last_index, 4, np.zeros(6, np.int32))


@vividc.kernel("void(int32[::1], int32[::1], int32[::1], int32)")
def loaded_limit(x, limits, y, m):
    """The inner loop's limit is loaded again and again, and only some threads come to it."""
    for i in prange(len(y)):
        k = np.int32(0)
        if x[i] > 3:
            while k < limits[m]:
                k += 1
            y[i] = x[k] + k


def test_a_thread_that_skips_a_loop_leaves_the_others_their_words() -> None:
    x = np.array([1, 9, 2, 5, 3, 3, 8, 1, 7], np.int32)
    agree(loaded_limit, 4, x, np.array([5, 3, 6], np.int32), np.zeros(9, np.int32), np.int32(1))
