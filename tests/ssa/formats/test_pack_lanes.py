"""Operations of several threads in the lanes of one: fewer of them, and the same words."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import vividc
from benchmarks.workloads import Workload
from tests.frontend.format_kernels import chains
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.formats import FORMATS
from vividc.program import Program
from vividc.ssa.check import check_function
from vividc.ssa.formats.pack_groups import find_groups
from vividc.ssa.formats.pack_lanes import pack_lanes
from vividc.ssa.ir import Function


def _operations(function: Function, part: str) -> list[str]:
    names = (instr.op.value for block in function.blocks for instr in block.instrs)
    return [name for name in names if part in name]


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, pack_lanes)


@pytest.mark.parametrize("fmt", FORMATS)
def test_a_loop_has_as_many_operations_as_words(fmt: str) -> None:
    function = chains(fmt).lower()
    packed = pack_lanes(function)
    assert check_function(packed) == []
    words = 4 // FORMATS[fmt].lanes
    for name in ("fma", "fmul", "fsub"):
        assert len(_operations(function, f"{name}.{fmt}")) == 4
        assert len(_operations(packed, f"{name}.{fmt}")) == words
    assert not _operations(packed, "fptrunc")
    assert len(_operations(packed, "unpack")) == 4


def test_what_has_no_twin_stays() -> None:
    plain = Workload("saxpy", lambda _: (), "saxpy").kernel().lower()
    assert find_groups(plain) == ()
    assert pack_lanes(plain) is plain


@pytest.mark.parametrize("fmt", FORMATS)
def test_packed_chains_are_those_of_numba(fmt: str) -> None:
    kernel = chains(fmt)
    program = vividc.compile(
        kernel, fabric="vivid-tile-unit", time_limit_s=5.0, loops=vividc.LoopOptions(auto=False)
    )
    x = np.random.default_rng(2).uniform(-1.2, 1.2, 12).astype(np.float32)
    x[5] = np.nan
    arguments = (x, np.zeros_like(x), 3, 6)
    host, native, reference = (copy.deepcopy(arguments) for _ in range(3))
    kernel(*host)
    vividc.simulate(program, *native)
    vividc.simulate(program, *reference, engine="reference")
    assert host[1].tobytes() == native[1].tobytes() == reference[1].tobytes()


def _throughput(program: Program) -> float:
    """FMAs of the loop in a cycle."""
    loop = max((r for r in program.regions if r.kind == "loop"), key=lambda r: r.operations)
    return 64 / loop.ii


@pytest.mark.parametrize(
    ("name", "rate"),
    [
        pytest.param("fma_fp32", 16, marks=pytest.mark.slow),
        pytest.param("fma_fp16", 32, marks=pytest.mark.slow),
        ("fma_fp8", 64),
    ],
)
def test_threads_reach_twice_and_four_times_the_rate(name: str, rate: int) -> None:
    kernel = Workload(name, lambda _: (), "precision").kernel()
    program = vividc.compile(
        kernel, fabric="vivid-tile-unit", loops=vividc.LoopOptions(threads=4), time_limit_s=30.0
    )
    x = np.linspace(-1, 1, 23).astype(np.float32)
    got, wanted = np.zeros(7, np.float32), np.zeros(7, np.float32)
    vividc.simulate(program, x, got, 5)
    kernel(x, wanted, 5)
    if name == "fma_fp32":
        assert np.allclose(got, wanted, rtol=1e-6)
    else:
        assert np.array_equal(got, wanted)
    assert _throughput(program) == rate
