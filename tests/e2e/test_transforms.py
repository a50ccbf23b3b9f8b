"""Transformed kernels compute what the kernels as written do, bit for bit, in fewer cycles."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks import general, workloads
from benchmarks.workloads import Arguments
from tests.e2e.test_general import SMALL, copies
from tests.e2e.test_kernels import assert_close
from vividc.program import Program

BY_NAME = {w.name: w for w in (*workloads.WORKLOADS, *general.WORKLOADS)}
FASTER = {
    "crc32_table": 2.0,
    "gemv": 1.5,
    "lookup": 1.2,
    "queens": 1.25,
    "saxpy": 1.5,
}
"""Least gain in cycles of the kernels that the quick tests transform."""

SLOW_FASTER = {"life": 5.0, "bit_reverse": 3.0, "fir": 1.5, "gemm_rows": 1.2}


@cache
def compiled(name: str) -> tuple[Program, Program]:
    """As written, and transformed."""
    kernel = BY_NAME[name].kernel()
    return vividc.compile(kernel, loops=vividc.LoopOptions(auto=False)), vividc.compile(kernel)


def assert_same(name: str, arguments: Arguments) -> tuple[int, int]:
    """Returns the cycles of both programs."""
    plain, transformed = compiled(name)
    by_plain, by_transformed, by_numba = (copies(arguments) for _ in range(3))
    before = vividc.simulate(plain, *by_plain)
    after = vividc.simulate(transformed, *by_transformed)
    value = BY_NAME[name].kernel()(*by_numba)
    for one, other in zip(by_plain, by_transformed, strict=True):
        assert np.asarray(one).tobytes() == np.asarray(other).tobytes()
    assert_close(by_transformed, by_numba)
    if value is not None:
        assert np.asarray(before.value).tobytes() == np.asarray(after.value).tobytes()
        assert_close((after.value,), (value,))
    return before.cycles, after.cycles


@pytest.mark.parametrize("name", list(FASTER))
def test_transformed_kernels_agree_and_gain(name: str) -> None:
    before, after = assert_same(name, BY_NAME[name].fresh())
    assert before >= FASTER[name] * after


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SLOW_FASTER))
def test_large_transformed_kernels_agree_and_gain(name: str) -> None:
    before, after = assert_same(name, BY_NAME[name].fresh())
    assert before >= SLOW_FASTER[name] * after


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in BY_NAME if n not in {**FASTER, **SLOW_FASTER}])
def test_all_kernels_agree(name: str) -> None:
    before, after = assert_same(name, BY_NAME[name].fresh())
    assert after <= 1.1 * before  # inputs shorter than assumed may lose what a remainder costs


@pytest.mark.parametrize("name", sorted(SMALL.keys() & FASTER.keys()))
def test_small_inputs(name: str) -> None:
    for arguments in SMALL[name]:
        assert_same(name, arguments)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SMALL.keys() - FASTER.keys()))
def test_all_small_inputs(name: str) -> None:
    for arguments in SMALL[name]:
        assert_same(name, arguments)


@pytest.mark.parametrize("length", range(12))
def test_every_remainder_of_an_unrolled_loop(length: int) -> None:
    x, y = np.arange(length, dtype=np.float32), np.ones(length, np.float32)
    assert_same("saxpy", (np.float32(1.5), x, y, np.int32(length)))


@pytest.mark.parametrize("rows", range(6))
def test_every_remainder_of_a_jammed_nest(rows: int) -> None:
    rng = np.random.default_rng(rows)
    a, x = rng.standard_normal((rows, 3)), rng.standard_normal(3)
    arrays = (a.astype(np.float32), x.astype(np.float32))
    y = np.ones(rows, np.float32)
    assert_same("gemv", (np.float32(1.5), *arrays, np.float32(0.5), y))


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def sums_of_one_product(x, y, b):
    for i in range(len(b)):
        s = b[i]
        for j in range(len(x)):
            s += x[j] * y[j]
        b[i] = s


def test_a_product_that_jammed_copies_share_rounds_as_in_one() -> None:
    rng = np.random.default_rng(0)
    x, y, b = (rng.standard_normal(n).astype(np.float32) for n in (37, 37, 16))
    written = b.copy()
    vividc.simulate(
        vividc.compile(sums_of_one_product, loops=vividc.LoopOptions(auto=False)), x, y, written
    )
    program = vividc.compile(sums_of_one_product)
    assert any(item.chosen for loop in program.loops for item in loop.transforms)
    vividc.simulate(program, x, y, b)
    np.testing.assert_array_equal(b, written)


def test_reports_say_what_was_done() -> None:
    plain, transformed = compiled("gemv")
    inner, outer = transformed.loops
    assert inner.cycles_before == 4
    assert inner.cycles_after is not None
    assert inner.cycles_after < 4
    assert "RecMII" in inner.binds
    [kind] = [item.kind for item in outer.transforms if item.chosen]
    assert kind in ("restructuring", "interleaving")
    assert not any(item.chosen for loop in plain.loops for item in loop.transforms)
