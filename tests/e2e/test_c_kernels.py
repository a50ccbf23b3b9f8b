"""The C kernels of `kernels/c/`: compiled from their `.ll` files, against the same files compiled
by LLVM for this computer, and the interpreter.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks.c_kernels import FILES, WORKLOADS
from benchmarks.workloads import KERNELS, Arguments
from tests.dfg.memory_trace import Trace
from tests.e2e.test_general import copies
from tests.e2e.test_kernels import assert_close
from tests.sim.native.agreement import agreed_run
from vividc import arch
from vividc.compiler.driver import lower
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.frontend.c.source import bodies
from vividc.program import Program, encode
from vividc.sim.bind import bind
from vividc.sim.engine import Launch

BY_NAME = {workload.name: workload for workload in WORKLOADS}
SLOW = {"sha256_rounds", "count_ends"}
NAMES = [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in BY_NAME]


def words(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def octets(*values: int) -> np.ndarray:
    return np.array(values, np.uint8)


def floats(*shape: int) -> np.ndarray:
    return np.random.default_rng(3).standard_normal(shape).astype(np.float32)


SMALL: dict[str, tuple[Arguments, ...]] = {
    "gemm": ((0, 3, 3, 1.0, 2.0, floats(9), floats(9), floats(9)),),
    "atax": ((2, 0, floats(1), floats(1), floats(1), floats(2)),),
    "transpose": ((words(5), 1), (words(5), 0), (words(1, 2, 3, 4), 2)),
    "trisolv": ((1, floats(1), floats(1), floats(1)), (0, floats(1), floats(1), floats(1))),
    "fir": ((words(*range(8)), words(*range(8)), words(9), 8), (words(1), words(1), words(9), -5)),
    "jacobi2d": ((2, 2, floats(2, 2), floats(2, 2)), (3, 3, floats(3, 3), floats(3, 3))),
    "prefix_sum": ((words(3), 0), (words(3), 1)),
    "crc32": ((np.array([7], np.uint32), 0), (np.array([7], np.uint32), 1)),
    "insertion_sort": ((words(3, 2), 1), (words(3, 2), 2), (words(3), -1)),
    "bubble_sort": ((words(3, 2), 0), (words(3, 2), 2)),
    "binary_search": ((words(1, 3, 5), 3, 5), (words(1, 3, 5), 3, 4), (words(1), 0, 1)),
    "partition": ((words(4), 1), (words(4, 4, 4), 3)),
    "find": ((words(1, 2, 3), 3, words(3, 4), 2), (words(1, 2, 3), 3, words(1), 0)),
    "crc32_table": ((octets(7), 0), (octets(7), 1), (octets(*range(250, 255)), 5)),
    "string_length": ((np.zeros(1, np.int8),), (np.array([-1, 0, 1], np.int8),)),
    "find_byte": ((octets(1, 255), 2, 255), (octets(1, 255), 2, 511), (octets(1), 0, 1)),
    "mix_pcm": ((*(np.full(2, -32768, np.int16) for _ in range(3)), 300, 300, 2),),
    "fnv1a": ((octets(0), 0, 2**64 - 1), (octets(255), 1, 2**63), (octets(1), -1, 0)),
    "xorshift64": ((2**64 - 1, 1), (1, 3), (2**63, 0)),
    "digits": ((0, 10, octets(0)), (2**32 - 1, 2, octets(*range(32)))),
    "counting_sort": ((octets(9, 3, 9), octets(0, 0, 0), 3), (octets(1), octets(2), 0)),
    "floyd_warshall": ((1, words(0).reshape(1, 1)), (0, words(7).reshape(1, 1))),
}


@cache
def compiled(name: str) -> tuple[vividc.LLKernel, Kernel, Program]:
    kernel = BY_NAME[name].kernel()
    lowered = lower(kernel)
    mapped, results = map_kernel(lowered, arch.load("vivid-tile"), CompileOptions())
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    return kernel, lowered, encode(mapped, arch.load("vivid-tile"), mappings, reports=results)


def assert_witnesses_agree(name: str, arguments: Arguments) -> None:
    kernel, lowered, program = compiled(name)
    by_array, by_host = copies(arguments), copies(arguments)
    result = vividc.simulate(program, *by_array, engine="native")
    value = kernel(*by_host)
    assert_close(by_array, by_host)
    assert (result.value is None) == (value is None)
    if value is not None:
        assert_close((result.value,), (value,))

    bound = bind(program, copies(arguments), {})
    launch = Launch(bound.memory.copy(), bound.inputs, 10**6, bound.extents)
    run = agreed_run(program, launch)
    trace = Trace(lowered)
    done = interpret(lowered, bound.memory, bound.inputs, watch=trace)
    trace.demand_order()
    np.testing.assert_array_equal(bound.memory, run.memory)
    assert done.value == run.value


@pytest.mark.parametrize("name", NAMES)
def test_witnesses_agree(name: str) -> None:
    *_, program = compiled(name)
    loops = [region for region in program.regions if region.kind == "loop"]
    assert loops
    assert {loop.status for loop in loops} == {"optimal"}
    assert_witnesses_agree(name, BY_NAME[name].fresh())


@pytest.mark.parametrize("name", SMALL)
def test_small_inputs(name: str) -> None:
    for arguments in SMALL[name]:
        assert_witnesses_agree(name, arguments)


@pytest.mark.parametrize(("name", "ii"), [("gemm", 1), ("fir", 1), ("jacobi2d", 1), ("find", 1)])
def test_loops_that_clang_rotated_are_counted_again(name: str, ii: int) -> None:
    *_, program = compiled(name)
    assert [region.ii for region in program.regions if region.kind == "loop"][-1] == ii


def test_every_function_of_the_files_is_in_the_table() -> None:
    for file, table in FILES.items():
        text = (KERNELS / "c" / f"{file}.ll").read_text()
        assert {body.name for body in bodies(text)} == set(table)


def test_source_lines_are_those_of_the_c_file() -> None:
    kernel = BY_NAME["gemm"].kernel()
    assert kernel.loc.file.endswith("linear_algebra.c")
    assert [param.name for param in kernel.params][:4] == ["ni", "nj", "nk", "alpha"]
    *_, program = compiled("gemm")
    source = (KERNELS / "c" / "linear_algebra.c").read_text().splitlines()
    [line] = {r.loc.line for r in program.regions if r.loc and "alpha" in source[r.loc.line - 1]}
    assert "c[i * nj + j] +=" in source[line - 1]
