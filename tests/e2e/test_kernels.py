"""Four witnesses on each kernel of `kernels/`: numba, the interpreter, the simulated words, and the
bounds.
"""

from __future__ import annotations

import numba
import numpy as np
import pytest

import vividc
from benchmarks.workloads import WORKLOADS, Workload
from tests.dfg.memory_trace import Trace
from tests.sim.native.agreement import agreed_run
from vividc import arch, lang
from vividc.compiler.driver import lower
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.interpret.interpreter import interpret
from vividc.program import Program, encode
from vividc.sim.bind import bind, returned
from vividc.sim.engine import Launch

FABRICS = ("vivid-tile", "vivid-tile-unit")
RTOL, ATOL = 1e-4, 1e-5
"""The array's exp is within 2 ulp, and FMAs round once where numba rounds twice."""

HOT_LOOP_II = {
    ("saxpy", "vivid-tile"): 1,
    ("saxpy", "vivid-tile-unit"): 1,
    ("dot", "vivid-tile"): 4,  # the FADD's latency
    ("dot", "vivid-tile-unit"): 1,
    ("fir", "vivid-tile"): 1,
    ("fir", "vivid-tile-unit"): 1,
    ("prefix_sum", "vivid-tile"): 4,  # store to load 1, load 2, add 1
    ("prefix_sum", "vivid-tile-unit"): 3,
    ("relu_gemv", "vivid-tile"): 4,
    ("relu_gemv", "vivid-tile-unit"): 1,
    ("count_until", "vivid-tile"): 1,
    ("count_until", "vivid-tile-unit"): 1,
    ("gs_blend", "vivid-tile"): 4,  # transmittance through one predicated FMUL
    ("gs_blend", "vivid-tile-unit"): 3,  # issue slots
}


@pytest.mark.parametrize("fabric", FABRICS)
@pytest.mark.parametrize("workload", WORKLOADS, ids=lambda w: w.name)
def test_witnesses_agree(workload: Workload, fabric: str) -> None:
    kernel = workload.kernel()
    machine = arch.load(fabric)
    lowered = lower(kernel)
    mapped, results = map_kernel(lowered, machine, CompileOptions(time_limit_s=60.0))
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    program = encode(mapped, machine, mappings, reports=results)

    hot = [region for region in program.regions if region.kind == "loop"][-1]
    assert (hot.ii, hot.status) == (HOT_LOOP_II[workload.name, fabric], "optimal")

    by_array, by_numba = workload.fresh(), workload.fresh()
    result = vividc.simulate(program, *by_array, engine="native")
    value = kernel(*by_numba)
    assert_close(by_array, by_numba)
    if value is not None:
        assert_close((result.value,), (value,))
    assert_interpreter_agrees(program, lowered, workload)
    assert_interpreter_agrees(program, mapped, workload)


def assert_close(ours: tuple[object, ...], numba: tuple[object, ...]) -> None:
    """Integers bit for bit, floats within the tolerance."""
    for mine, theirs in zip(ours, numba, strict=True):
        if np.asarray(theirs).dtype.kind == "f":
            np.testing.assert_allclose(mine, theirs, rtol=RTOL, atol=ATOL)
        else:
            np.testing.assert_array_equal(mine, theirs)


def assert_interpreter_agrees(program: Program, kernel: object, workload: Workload) -> None:
    """Memory and returned word after the interpreter equal the simulator's, bit for bit."""
    bound = bind(program, workload.fresh(), {})
    run = agreed_run(program, Launch(bound.memory.copy(), bound.inputs, 10**8, bound.extents))
    memory = bound.memory.copy()
    trace = Trace(kernel)
    done = interpret(kernel, memory, bound.inputs, watch=trace)  # type: ignore[arg-type]
    trace.demand_order()
    np.testing.assert_array_equal(memory, run.memory)
    assert done.value == run.value


def test_without_contraction_floats_equal_numba_bit_for_bit() -> None:
    """saxpy has no exp: without FMAs every rounding is numba's."""
    workload = WORKLOADS[0]
    program = vividc.compile(workload.kernel(), contract=False)
    by_array, by_numba = workload.fresh(), workload.fresh()
    vividc.simulate(program, *by_array)
    workload.kernel()(*by_numba)
    np.testing.assert_array_equal(np.asarray(by_array[2]), np.asarray(by_numba[2]))


@vividc.kernel("void(float32[:,::1], float32[:,::1])")
def differences(x, y):
    total = np.float32(0.0)
    for i in range(x.shape[1]):
        y[0, i] = x[2, i] - x[0, i] * x[1, i]
        y[1, i] = x[1, i] * x[2, i] - x[0, i]
        if x[0, i] < x[1, i]:
            total -= x[0, i] * x[2, i]
        y[2, i] = total


@numba.njit
def fused_differences(x, y):
    total = np.float32(0.0)
    for i in range(x.shape[1]):
        y[0, i] = lang.fma(-x[0, i], x[1, i], x[2, i])
        y[1, i] = lang.fma(x[1, i], x[2, i], -x[0, i])
        if x[0, i] < x[1, i]:
            total = lang.fma(-x[0, i], x[2, i], total)
        y[2, i] = total


@pytest.mark.parametrize("engine", ["native", "reference"])
def test_a_product_taken_from_something_is_llvms_fma_of_its_negative(engine: str) -> None:
    x = np.random.default_rng(3).standard_normal((3, 40)).astype(np.float32)
    x[2, ::3] = x[0, ::3] * x[1, ::3]  # what is left is the product's rounding error
    x[:, -6:] = [[0, -0.0, 0, np.inf, 1, 1], [1, 1, -1, 0, 2, 2], [0, 0, -0.0, 1, np.nan, np.inf]]
    ours, theirs = np.zeros((2, *x.shape), np.float32)
    vividc.simulate(vividc.compile(differences), x, ours, engine=engine)
    fused_differences(x, theirs)
    assert np.array_equal(np.isnan(ours), np.isnan(theirs))
    known = ~np.isnan(ours)
    assert np.array_equal(ours.view(np.uint32)[known], theirs.view(np.uint32)[known])


def test_returned_words_have_the_declared_type() -> None:
    program = vividc.compile(WORKLOADS[1].kernel())
    result = vividc.simulate(program, *WORKLOADS[1].fresh())
    assert isinstance(result.value, float)
    assert program.returns is not None
    assert returned(program.returns, 0) == 0.0
