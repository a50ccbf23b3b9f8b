"""Arithmetic in a format by policy is what the same casts in the source give, to the bit."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.frontend.policy_kernels import chain, chain_in, inner, inner_in
from vividc.ssa.check import check_function
from vividc.ssa.formats.in_format import in_format
from vividc.ssa.formats.precision import FORMAT_NAMES

X = np.concatenate(
    [np.random.default_rng(4).uniform(-3, 3, 13), [np.nan, np.inf, 1e-6, -0.0, 447.0]]
).astype(np.float32)


@pytest.mark.parametrize("name", ["fp16", "fp8", "e5m2"])
@pytest.mark.parametrize("threads", [1, 4])
def test_chains_with_data_dependent_steps(name: str, threads: int) -> None:
    wanted = np.zeros_like(X)
    chain_in(name)(X, wanted, 5)
    program = vividc.compile(
        chain,
        precision={"fma": name},
        loops=vividc.LoopOptions(auto=False, threads=threads),
        time_limit_s=5.0,
        effort="fast",
    )
    for engine in ("native", "reference"):
        got = np.zeros_like(X)
        vividc.simulate(program, X, got, 5, engine=engine)
        assert np.array_equal(got, wanted, equal_nan=True)


@pytest.mark.parametrize("name", ["fp16", "fp8", "e5m2"])
def test_a_sum_is_carried_in_the_format(name: str) -> None:
    x = np.random.default_rng(6).uniform(-2, 2, 40).astype(np.float32)
    program = vividc.compile(inner, precision={"fma": name}, time_limit_s=5.0, effort="fast")
    assert vividc.simulate(program, x, x[::-1].copy()).value == inner_in(name)(x, x[::-1].copy())


@pytest.mark.parametrize("name", ["fp16", "fp8"])
def test_a_carried_number_is_not_converted_in_the_loop(name: str) -> None:
    fmt = FORMAT_NAMES[name]
    assert fmt is not None
    function = in_format(inner.lower(), fmt)
    assert check_function(function) == []
    [loop] = [b for b in function.blocks if any(i.op.value.startswith("fma.") for i in b.instrs)]
    names = [instr.op.value.partition(".")[0] for instr in loop.instrs]
    assert names.count("fptrunc") == 2  # the two loaded factors
    assert "fpext" not in names


def test_a_policy_that_changes_nothing_is_told() -> None:
    with pytest.warns(vividc.VividcWarning, match="inner has no exp"):
        program = vividc.compile(
            inner,
            precision={"exp": "fp8"},
            time_limit_s=3.0,
            loops=vividc.LoopOptions(auto=False),
            effort="fast",
        )
    assert any("exp" in text for text in program.warnings)
