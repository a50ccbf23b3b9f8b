"""A loop without a modulo schedule still compiles: it runs block by block, and says so."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from benchmarks.workloads import WORKLOADS
from vividc.compiler.regions import map_regions
from vividc.mapper import MapResult


@pytest.mark.parametrize("workload", WORKLOADS, ids=lambda w: w.name)
def test_it_runs_block_by_block(workload: object, monkeypatch: pytest.MonkeyPatch) -> None:
    timeout = MapResult("timeout", None, 1, (), None, "none", 0.0)
    monkeypatch.setattr(map_regions, "map_dfg", lambda *_, **__: timeout)
    kernel = workload.kernel()  # type: ignore[attr-defined]
    with pytest.warns(vividc.VividcWarning, match="took too long and runs block by block"):
        program = vividc.compile(kernel)
    assert {region.kind for region in program.regions} == {"straight"}
    assert "runs block by block" in program.warnings[0]
    by_array, by_numba = workload.fresh(), workload.fresh()  # type: ignore[attr-defined]
    result = vividc.simulate(program, *by_array)
    value = kernel(*by_numba)
    for mine, theirs in zip(by_array, by_numba, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-4, atol=1e-5)
    if value is not None:
        np.testing.assert_allclose(result.value, value, rtol=1e-4)
