"""Two versions of a loop: what a test before it proves, and that both mean what the loop meant."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.fuzz.forms import OPTIONS
from tests.fuzz.witnesses import run_regions
from tests.ssa.support import demand_same, loop_at
from vividc import arch
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
from vividc.frontend import KernelFunction, kernel
from vividc.mapper import MapProblem
from vividc.mapper.bounds.bounds import all_bounds
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Const, Instr
from vividc.ssa.loops.versions import Versions, versions
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

MACHINE = arch.load("vivid-tile")
TWO = np.float32(2)
SIGNATURE = "void(float32[::1], int32, int32, int32)"


@kernel(SIGNATURE)
def by_five_from(x, m, n, k):
    """Where n is negative, some elements count from the end."""
    for i in range(m):
        x[5 * i + n] *= TWO


@kernel(SIGNATURE)
def from_ahead(x, m, n, k):
    """Anti-dependences alone, unless n is negative."""
    for i in range(m):
        x[i] = x[i + n] * TWO


@kernel(SIGNATURE)
def to_behind(x, m, n, k):
    """Two parts of an array, if there are no more elements than between them."""
    for i in range(m):
        x[i + n] = x[i] * TWO


@kernel(SIGNATURE)
def of_two(x, m, n, k):
    """Two tests."""
    for i in range(m):
        x[i] = x[i + n] * TWO + x[i + k]


@kernel(SIGNATURE)
def by_a_stride(x, m, n, k):
    """All the same element where n is 0; some count from the end where it is negative."""
    for i in range(m):
        x[n * i] *= TWO


@kernel(SIGNATURE)
def ahead_by_a_stride(x, m, n, k):
    """The next iteration reads what is stored where n is 3."""
    for i in range(m):
        x[n * i + 3] = x[n * i] * TWO


TESTED = (by_five_from, from_ahead, to_behind, of_two, by_a_stride, ahead_by_a_stride)


@kernel(SIGNATURE)
def sure(x, m, n, k):
    for i in range(1, m):
        x[i] = x[i - 1] * TWO


@kernel(SIGNATURE)
def apart(x, m, n, k):
    for i in range(m):
        x[2 * i + 1] = x[2 * i] * TWO


@kernel("void(float32[::1], int32[::1], int32)")
def looked_up(x, places, m):
    for i in range(m):
        x[places[i]] *= TWO


@kernel(SIGNATURE)
def odd_by_a_stride(x, m, n, k):
    """Words wrap: 2**31 times every other number is 0."""
    for i in range(m):
        if i & 1:
            x[n * i] *= TWO


@kernel(SIGNATURE)
def by_twice_a_stride(x, m, n, k):
    for i in range(m):
        x[np.int32(np.int32(2) * n * i)] *= TWO


@kernel(SIGNATURE)
def by_a_stride_from_a_scalar(x, m, n, k):
    """Where k is negative, elements from the end and from the start are the same."""
    for i in range(m):
        x[n * i + k] *= TWO


ONE_VERSION = (
    sure,
    apart,
    looked_up,
    odd_by_a_stride,
    by_twice_a_stride,
    by_a_stride_from_a_scalar,
)


def made(given: KernelFunction) -> Versions | Refusal:
    function = tidy(given.lower())
    [loop] = find_loops(function)
    return versions(function, loop)


@pytest.mark.parametrize("given", TESTED, ids=lambda given: given.name)
def test_one_version_has_no_recurrence_through_memory(given: KernelFunction) -> None:
    done = made(given)
    assert isinstance(done, Versions)
    assert check_function(done.function) == []
    regions = optimize_kernel(build_kernel(normalize(done.function))).regions
    dfgs = [region.dfg for region in regions if region.kind == "loop"]
    bounds = [{b.name: b.ii for b in all_bounds(MapProblem(dfg, MACHINE))} for dfg in dfgs]
    assert sorted(one.get("RecMII", 1) for one in bounds)[0] == 1
    assert sorted(one.get("RecMII", 1) for one in bounds)[1] >= 7


@pytest.mark.parametrize("given", TESTED, ids=lambda given: given.name)
def test_both_versions_mean_what_the_loop_meant(given: KernelFunction) -> None:
    done = made(given)
    assert isinstance(done, Versions)
    demand_same(tidy(given.lower()), tidy(done.function), tries=60)
    assert loop_at(done.function, done.apart) != loop_at(done.function, done.meeting)


@pytest.mark.parametrize("given", TESTED, ids=lambda given: given.name)
@pytest.mark.parametrize("n", [0, 1, 3, 12, -1, -3])
def test_what_meets_is_kept_in_order(given: KernelFunction, n: int) -> None:
    """`run_regions` traces memory."""
    done = made(given)
    assert isinstance(done, Versions)
    lowered = optimize_kernel(build_kernel(normalize(done.function)), OPTIONS)
    for m, k in ((4, 1), (9, -2), (0, 0)):
        mine, numbas = (np.random.default_rng(n + 9).random(160, np.float32) for _ in "12")
        args = [np.int32(number) for number in (m, n, k)]
        given(numbas, *args)
        run_regions(lowered, [mine, *args])
        assert np.array_equal(mine, numbas)


@pytest.mark.parametrize("given", ONE_VERSION, ids=lambda given: given.name)
def test_where_no_test_helps_there_is_one_version(given: KernelFunction) -> None:
    assert isinstance(made(given), Refusal)


def test_the_test_is_a_comparison_of_what_is_fixed() -> None:
    done = made(by_five_from)
    assert isinstance(done, Versions)
    instrs = [item for block in done.function.blocks for item in block.instrs]
    [test] = [i for i in instrs if isinstance(i, Instr) and i.operands[:1] == (Const(0),)]
    assert [getattr(operand, "key", "") for operand in test.operands] == ["", "n"]


@pytest.mark.parametrize("n", [3, 40, -1, -7])
def test_a_program_runs_the_version_that_fits(n: int) -> None:
    with vividc.patient(10):
        program = vividc.compile(from_ahead)
    mine, numbas = (np.random.default_rng(1).random(160, np.float32) for _ in "12")
    args = (np.int32(100), np.int32(n), np.int32(0))
    cycles = vividc.simulate(program, mine, *args).cycles
    from_ahead(numbas, *args)
    assert np.array_equal(mine, numbas)
    assert cycles < 450 if n > 0 else cycles >= 700
