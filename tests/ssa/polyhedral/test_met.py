"""The exact dependences hold all iterations that meet in memory when kernels run."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.c_kernels import WORKLOADS as C
from benchmarks.general import WORKLOADS as GENERAL
from benchmarks.polybench.inputs import INPUTS
from benchmarks.polybench.suite import CASES, MINI
from benchmarks.render_kernels import WORKLOADS as RENDER
from benchmarks.workloads import WORKLOADS, Workload
from tests.marks import with_slow
from tests.ssa.polyhedral.met import demand_dependences, has_words_only
from tests.ssa.polyhedral.test_generate import parts_of
from tests.ssa.polyhedral.wide_nests import WIDTH, random_wide_nest
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.rewrite.tidy import tidy

QUICK = {"floyd-warshall", "seidel-2d", "trisolv"}
SIZES = (4, 5, 6, 3, 4)
"""At most, of arguments of inputs in their order: less than `MINI`, whose every access would be
watched."""


@pytest.mark.filterwarnings("ignore:.*converted to a 64-bit integer saturates")
@pytest.mark.parametrize("name", with_slow(CASES, CASES.keys() - QUICK))
def test_all_that_meets_in_polybench(name: str) -> None:
    case = CASES[name]
    sizes = (min(n, most) for n, most in zip(case.sizes[MINI], SIZES, strict=False))
    args = INPUTS[case.kernel.name](*sizes)
    function = tidy(case.kernel.lower())
    met = [demand_dependences(function, scop, args) for scop in parts_of(function)]
    assert any(met) or name not in QUICK


@pytest.mark.slow
@pytest.mark.parametrize("workload", [*WORKLOADS, *GENERAL, *RENDER, *C], ids=lambda w: w.name)
def test_all_that_meets_in_kernels(workload: Workload) -> None:
    kernel = workload.kernel()
    function = tidy(kernel.lower())
    if has_words_only(function):
        for scop in parts_of(function):
            demand_dependences(function, scop, workload.fresh())


def test_all_that_meets_in_random_nests() -> None:
    met = 0
    for seed in range(25):
        function = tidy(random_wide_nest(seed))
        for scop in parts_of(function):
            for n, m in ((6, 7), (9, 8)):
                words = np.random.default_rng(seed).integers(-9, 9, (3, WIDTH, WIDTH), np.int32)
                a, b, f = words
                g = np.zeros(m, np.int32)
                args = (a, b, f.view(np.float32), a[0].copy(), g, n)
                met += demand_dependences(function, scop, args)
    assert met > 300


def test_a_dependence_that_is_left_out_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    case = CASES["trisolv"]
    function = tidy(case.kernel.lower())
    [scop] = parts_of(function)
    none = Relations(scop).dependences.subtract(Relations(scop).dependences)
    monkeypatch.setattr(Relations, "dependences", none)
    with pytest.raises(AssertionError, match="not among the dependences"):
        demand_dependences(function, scop, INPUTS[case.kernel.name](4))
