"""Ordinary kernels of many fields on the tile: against numba, the interpreter, and empty inputs."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks.general import WORKLOADS
from benchmarks.workloads import Arguments
from tests.dfg.memory_trace import Trace
from tests.e2e.test_kernels import assert_close
from tests.sim.native.agreement import agreed_run
from vividc import arch
from vividc.compiler.driver import lower
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.program import Program, encode
from vividc.sim.bind import bind
from vividc.sim.engine import Launch

BY_NAME = {workload.name: workload for workload in WORKLOADS}
QUICK = {
    "apply_curve",
    "bellman_ford",
    "bfs",
    "binary_search",
    "bubble_sort",
    "compact",
    "conv2d",
    "crc32",
    "dot64",
    "first_match",
    "floyd_warshall",
    "gauss_seidel",
    "grow_region",
    "haar",
    "histogram",
    "knapsack",
    "mandelbrot",
    "merge",
    "mix_pcm",
    "montgomery",
    "quantised_layer",
    "quickselect",
    "run_length_encode",
    "sieve",
    "spmv_csr",
    "trmv",
    "virtual_machine",
    "xtea",
}


def words(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def unsigned(*values: int) -> np.ndarray:
    return np.array(values, np.uint32)


def octets(*values: int) -> np.ndarray:
    return np.array(values, np.uint8)


def halves(*values: int) -> np.ndarray:
    return np.array(values, np.int16)


def floats(*shape: int) -> np.ndarray:
    return np.random.default_rng(1).standard_normal(shape).astype(np.float32)


SMALL: dict[str, tuple[Arguments, ...]] = {
    "gemm": (
        (floats(3, 0), floats(0, 2), floats(3, 2)),
        (floats(1, 1), floats(1, 1), floats(1, 1)),
    ),
    "trmv": ((floats(0, 0), floats(0)), (floats(1, 1), floats(1))),
    "transpose": ((floats(1, 1),), (floats(2, 2),)),
    "norm_inf": ((floats(0, 3),), (floats(3, 0),)),
    "spmv_csr": ((words(0, 0, 0), words(), floats(0), floats(3), floats(2)),),
    "blur3": ((np.ones((2, 9), np.int32), np.zeros((2, 9), np.int32)),),
    "histogram": ((words(), words(0, 0)), (words(1), words(0, 0))),
    "fir_filter": ((floats(0), floats(3), floats(0)), (floats(1), floats(3), floats(1))),
    "haar": ((words(5), words(0)), (words(5, -8), words(0, 0))),
    "crc32": ((unsigned(),), (unsigned(97),)),
    "adler32": ((words(),), (words(255),)),
    "xtea": ((unsigned(), unsigned(1, 2, 3, 4)), (unsigned(1, 2, 3), unsigned(1, 2, 3, 4))),
    "popcount": ((unsigned(0, 2**32 - 1, 2**31), words(9, 9, 9)),),
    "fnv1a_64": ((unsigned(),), (unsigned(2**32 - 1),)),
    "splitmix64": ((2**64 - 1, unsigned(), unsigned()), (0, unsigned(1), unsigned(1))),
    "q31_multiply": (
        (words(-(2**31), -(2**31), 2**31 - 1), words(-(2**31), 1, 2**31 - 1), words(0, 0, 0)),
    ),
    "dot64": ((words(), words()), (words(-(2**31), -(2**31)), words(-(2**31), -(2**31)))),
    "squares_until": (
        (words(2**31 - 1, 2**31 - 1, 7), 2**62),
        (words(-(2**31), -(2**31), 7), -1),
        (words(3, 4), 2**63 - 1),
    ),
    "montgomery": (
        (unsigned(2**31 - 2, 0, 1), np.uint32(2**31 - 1), np.uint32(2**31 + 1), unsigned(9, 9, 9)),
    ),
    "power_modulo_wide": ((-5, 3), (2**63 - 1, 0), (-(2**63), 1)),
    "gcd64": ((2**62, 2**32), (1, 2**63 - 1)),
    "integer_root": ((0,), (np.int32(99),)),
    "insertion_sort": ((words(),), (words(4),), (words(4, -4),)),
    "selection_sort": ((floats(0),), (floats(1),), (floats(2),)),
    "bubble_sort": ((words(),), (words(4),), (words(1, 2, 3, 4),)),
    "heap_sort": ((words(),), (words(4),), (words(4, 3),)),
    "comb_filter": ((floats(3), 5, np.float32(1)), (floats(4), 0, np.float32(1))),
    "queens": ((words(3),), (words(0, 0),)),
    "shell_sort": ((words(),), (words(4),), (words(4, 3),)),
    "binary_search": ((words(), words(3), words(0)), (words(3), words(3, 2, 4), words(0, 0, 0))),
    "merge": (
        (words(), words(), words()),
        (words(), words(1, 2), words(0, 0)),
        (words(3), words(), words(0)),
    ),
    "exclusive_scan": ((words(), words()), (words(-7), words(1))),
    "argmax": ((floats(0),), (floats(1),), (np.full(3, np.nan, np.float32),)),
    "find_text": ((words(), words()), (words(1), words(1, 2)), (words(1, 2), words(2))),
    "compact": ((words(), words()), (words(0), words(5)), (words(2), words(5))),
    "quickselect": ((words(8), 0), (words(8, 7), 0), (words(3, 3, 3), 1)),
    "pair_with_sum": ((words(), 3, words(0, 0)), (words(1, 2), 3, words(0, 0))),
    "bfs": ((words(0, 0), words(), 0, words(-1), words(0)),),
    "bellman_ford": (
        (words(), words(), words(), words(0)),
        (words(0, 1), words(1, 0), words(1, -2), words(0, 1 << 20)),
    ),
    "longest_common": ((words(), words(1, 2), np.ones((1, 3), np.int32)),),
    "edit_distance": ((words(), words(1, 2), words(0, 0, 0)), (words(1, 2), words(), words(9))),
    "largest_subarray": ((words(-5),), (words(-5, -3),)),
    "mandelbrot": ((floats(1), floats(1), 0, np.ones((1, 1), np.int32)),),
    "nested_breaks": ((np.zeros((3, 0), np.int32), 5), (np.zeros((0, 3), np.int32), 5)),
    "first_match": (
        (np.zeros((2, 0, 2), np.int32), 1),
        (np.ones((1, 1, 1), np.int32), 1),
        (np.zeros((2, 2, 2), np.int32), 1),
    ),
    "sieve": ((words(),), (words(7),), (words(7, 7, 7, 7, 7),)),
    "gray_histogram": ((np.full((3, 1), 255, np.uint8), np.zeros(256, np.int32)),),
    "threshold_mask": (
        (octets(), np.uint8(0), np.zeros(0, bool)),
        (octets(0, 255, 254), np.uint8(254), np.ones(3, bool)),
    ),
    "box_blur": ((octets(1, 2).reshape(1, 2), octets(3, 4).reshape(1, 2)),),
    "blend_over": (
        (octets(0, 255, 255, 7), octets(255, 255, 0, 9), octets(255, 0, 255, 128)),
        (octets(), octets(), octets()),
    ),
    "run_length_encode": (
        (octets(), octets(9)),
        (octets(5), octets(0, 0)),
        (np.full(600, 255, np.uint8), np.zeros(6, np.uint8)),
    ),
    "crc8": ((octets(),), (octets(255),), (octets(*b"123456789"),)),
    "adler32_bytes": ((octets(),), (octets(255),)),
    "utf8_length": ((octets(),), (octets(*"aé€🙂".encode()),)),
    "mix_pcm": (
        (halves(32767, -32768, 5), halves(1, -1, -5), halves(0, 0, 0)),
        (halves(), halves(), halves()),
    ),
    "delta_decode": ((halves(),), (halves(7),), (halves(32767, 1, -32768, -1),)),
    "grow_region": ((np.ones((2, 3), bool), np.ones((2, 3), bool)),),
    "base64_encode": ((octets(1, 2), octets(*range(64)), octets()),),
    "quantised_layer": (
        (
            np.full((2, 3), -128, np.int8),
            np.array([-128, -128, -128], np.int8),
            words(-50_000, 0),
            np.int8(0),
            np.zeros(2, np.int8),
        ),
    ),
    "loudest": ((np.array([-128], np.int8),), (np.array([-1, -128, -2], np.int8),)),
    "bracket_match": ((words(), words()), (words(41), words(0)), (words(40, 40), words(0, 0))),
}


def quick_first(names: list[str]) -> list[object]:
    """Test parameters; those outside the quick subset are slow."""
    slow = pytest.mark.slow
    return [pytest.param(name, marks=() if name in QUICK else slow) for name in names]


@cache
def compiled(name: str) -> tuple[vividc.KernelFunction, Kernel, Program]:
    """The kernel, its graphs before mapping, and its program."""
    machine = arch.load("vivid-tile")
    kernel = BY_NAME[name].kernel()
    lowered = lower(kernel)
    effort = "normal" if name in QUICK else "thorough"  # of which all loops come with proofs
    mapped, results = map_kernel(lowered, machine, CompileOptions(effort=effort))
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    return kernel, lowered, encode(mapped, machine, mappings, reports=results)


def copies(arguments: Arguments) -> Arguments:
    return tuple(a.copy() if isinstance(a, np.ndarray) else a for a in arguments)


def assert_witnesses_agree(name: str, arguments: Arguments) -> int:
    """Returns the simulated cycles."""
    kernel, lowered, program = compiled(name)
    by_array, by_numba = copies(arguments), copies(arguments)
    result = vividc.simulate(program, *by_array, engine="native")
    value = kernel(*by_numba)
    assert_close(by_array, by_numba)
    if value is None:
        assert result.value is None
    else:
        assert_close((result.value,), (value,))

    bound = bind(program, copies(arguments), {})
    launch = Launch(bound.memory.copy(), bound.inputs, 10**6, bound.extents)
    run = agreed_run(program, launch)
    trace = Trace(lowered)
    done = interpret(lowered, bound.memory, bound.inputs, watch=trace)
    trace.demand_order()
    np.testing.assert_array_equal(bound.memory, run.memory)
    assert done.value == run.value
    return result.cycles


@pytest.mark.parametrize("name", quick_first(list(BY_NAME)))
def test_witnesses_agree(name: str) -> None:
    *_, program = compiled(name)
    loops = [region for region in program.regions if region.kind == "loop"]
    assert loops
    assert {loop.status for loop in loops} == {"optimal"}
    assert assert_witnesses_agree(name, BY_NAME[name].fresh()) < 20_000


@pytest.mark.parametrize("name", quick_first(list(SMALL)))
def test_small_inputs(name: str) -> None:
    for arguments in SMALL[name]:
        assert_witnesses_agree(name, arguments)


def test_every_file_has_only_kernels_of_the_table() -> None:
    """A kernel that nobody runs would be a claim without proof."""
    for file in {workload.file for workload in WORKLOADS}:
        first = next(workload for workload in WORKLOADS if workload.file == file)
        names = {w.name for w in WORKLOADS if w.file == file}
        scope = first.kernel().py_func.__globals__
        assert {n for n, v in scope.items() if isinstance(v, vividc.KernelFunction)} == names
