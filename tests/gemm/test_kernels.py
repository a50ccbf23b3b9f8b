"""Kernels that are matrix products, on an accelerator in each mode."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba import prange
from numpy.typing import NDArray

import vividc
from vividc import arch
from vividc.errors import ArgumentError, KernelError, SimulationError
from vividc.gemm.kernels import choose_for, explain
from vividc.gemm.passes import with_arrays
from vividc.gemm.systolic import SystolicError
from vividc.program import Program

RNG = np.random.default_rng(5)
VIVID = with_arrays(arch.load_accelerator("vivid"))

Matrix = NDArray[np.float32]


def random(*shape: int) -> Matrix:
    return RNG.standard_normal(shape).astype(np.float32)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1], float32[:, ::1])")
def layer(a, w, bias, c):
    for i in range(a.shape[0]):
        for j in range(w.shape[0]):
            total = bias[j]
            for k in range(a.shape[1]):
                total += a[i, k] * w[j, k]
            c[i, j] = max(total, np.float32(0))


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def doubled(a, c):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            c[i, j] = a[i, j] + a[i, j]


@pytest.fixture(scope="module")
def program() -> Program:
    return vividc.compile(
        layer, fabric="vivid", loops=vividc.LoopOptions(auto=False), mode="tpu-partitioned"
    )


def in_mode(program: Program, mode: str) -> Program:
    assert program.product is not None
    return replace(program, product=replace(program.product, mode=mode))


def arguments(rows: int = 50, depth: int = 5, cols: int = 9) -> tuple[Matrix, ...]:
    zeros = np.zeros((rows, cols), np.float32)
    return random(rows, depth), random(cols, depth), random(cols), zeros


def test_modes_give_the_same_bits(program: Program) -> None:
    a, w, bias, c = arguments()
    result = vividc.simulate(program, a, w, bias, c, fabric="vivid")
    assert {event.program for event in result.events if event.kind == "run"} == {"gemm"}
    tiles = np.zeros_like(c)
    other = vividc.simulate(in_mode(program, "gpu"), a, w, bias, tiles, fabric="vivid")
    assert {event.program for event in other.events if event.kind == "run"} == {"layer"}
    assert np.array_equal(c, tiles)
    host = np.zeros_like(c)
    layer(a, w, bias, host)
    np.testing.assert_allclose(c, host, rtol=1e-5, atol=1e-5)


def test_a_program_keeps_its_product_in_its_file(program: Program, tmp_path: Path) -> None:
    program.save(tmp_path / "layer.vivid")
    assert vividc.load(tmp_path / "layer.vivid").product == program.product


def test_auto_takes_the_mode_with_fewest_cycles(program: Program) -> None:
    auto = in_mode(program, "auto")
    assert auto.product is not None
    small = choose_for(auto, auto.product, (4, 4, 4), VIVID)
    large = choose_for(auto, auto.product, (4096, 64, 64), VIVID)
    assert small.mode == "gpu"
    assert large.mode == "tpu-unified"
    assert set(large.cycles) == {"gpu", "tpu-unified", "tpu-partitioned"}
    a, w, bias, c = arguments(3, 2, 2)
    result = vividc.simulate(auto, a, w, bias, c, fabric="vivid")
    assert {event.program for event in result.events if event.kind == "run"} == {"layer"}
    deep = choose_for(auto, auto.product, (4096, 64, 600), VIVID)
    assert deep.mode == "gpu"
    assert "tpu-unified not: an inner dimension of 600" in deep.reason


def test_explain_says_why(program: Program) -> None:
    text = explain(in_mode(program, "auto"), VIVID)
    assert text.startswith("matrix product c = max(a w^T + bias, 0): 4096x64 by 64x64: mode tpu-")
    assert "fewest cycles predicted: gpu (1 tile)" in text
    assert "asked for" in explain(program, VIVID)


def test_operands_whose_products_may_overflow_run_on_the_tiles(program: Program) -> None:
    a, w, bias, c = arguments()
    a[3, 2] = np.nan
    with pytest.raises(ArgumentError, match="an operand is not finite"):
        vividc.simulate(program, a, w, bias, c, fabric="vivid")
    a[3, 2] = np.float32(3e38)
    with pytest.raises(ArgumentError, match="might overflow"):
        vividc.simulate(program, a, w, bias, c, fabric="vivid")
    vividc.simulate(in_mode(program, "auto"), a, w, bias, c, fabric="vivid")


def test_loops_over_a_part_of_an_array_are_told(program: Program) -> None:
    a, w, bias, c = arguments()
    with pytest.raises(ArgumentError, match="do not run over all of c, 51x9"):
        vividc.simulate(program, a, w, bias, np.zeros((51, 9), np.float32), fabric="vivid")
    with pytest.raises(ArgumentError, match="do not run over all of bias"):
        vividc.simulate(program, a, w, random(10), c, fabric="vivid")
    empty = (random(0, 5), w, bias, np.zeros((0, 9), np.float32))
    with pytest.raises(ArgumentError, match="nothing to compute"):
        vividc.simulate(program, *empty, fabric="vivid")


def test_modes_that_are_not_possible() -> None:
    with pytest.raises(ArgumentError, match="unknown mode 'tpu'"):
        vividc.compile(layer, fabric="vivid", mode="tpu")
    with pytest.raises(KernelError, match="doubled cannot run in mode tpu-unified: it has 2 loops"):
        vividc.compile(doubled, fabric="vivid", mode="tpu-unified")
    with pytest.raises(KernelError, match="the fabric is one tile"):
        vividc.compile(layer, mode="tpu-unified")
    with pytest.raises(KernelError, match="--no-contract forbids"):
        vividc.compile(layer, fabric="vivid", mode="tpu-unified", contract=False)


def test_a_product_that_does_not_fit_is_told(program: Program) -> None:
    a, w, bias, c = random(4, 600), random(3, 600), random(3), np.zeros((4, 3), np.float32)
    with pytest.raises(SystolicError, match="takes 602 contexts"):
        vividc.simulate(program, a, w, bias, c, fabric="vivid")


def test_a_run_past_the_cycle_limit_is_told(program: Program) -> None:
    a, w, bias, c = arguments()
    with pytest.raises(SimulationError, match="after 100 cycles"):
        vividc.simulate(program, a, w, bias, c, fabric="vivid", cycle_limit=100)
    assert not c.any()


def test_an_observer_watches_one_tile(program: Program) -> None:
    with pytest.raises(ArgumentError, match="observer"):
        vividc.simulate(program, *arguments(), fabric="vivid", observer=lambda *seen: None)


SQUARE = "void(float32[:, ::1], float32[:, ::1], float32[:, ::1])"


def columns_in_parallel(a, b, c):
    for j in prange(b.shape[1]):
        for i in range(a.shape[0]):
            s = np.float32(0)
            for k in range(a.shape[1]):
                s += a[i, k] * b[k, j]
            c[i, j] = s


def stored_transposed(a, b, c):
    for i in prange(a.shape[0]):
        for j in range(b.shape[1]):
            s = np.float32(0)
            for k in range(a.shape[1]):
                s += a[i, k] * b[k, j]
            c[j, i] = s


def second_transposed(a, b, c):
    for i in prange(a.shape[0]):
        for j in range(b.shape[0]):
            s = np.float32(0)
            for k in range(a.shape[1]):
                s += a[i, k] * b[j, k]
            c[i, j] = s


def first_transposed(a, b, c):
    for i in prange(a.shape[1]):
        for j in range(b.shape[1]):
            s = np.float32(0)
            for k in range(a.shape[0]):
                s += a[k, i] * b[k, j]
            c[i, j] = s


PARALLEL = (columns_in_parallel, stored_transposed, second_transposed, first_transposed)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*runs on one tile only")
@pytest.mark.parametrize("function", PARALLEL, ids=lambda function: function.__name__)
def test_products_over_prange_are_numbas_in_each_mode(function: Callable[..., None]) -> None:
    """Whole numbers, so that no order of their sums matters."""
    kernel = vividc.kernel(SQUARE)(function)
    program = vividc.compile(kernel, fabric="vivid", loops=vividc.LoopOptions(auto=False))
    for rows, cols, depth in ((1, 1, 1), (7, 5, 3), (16, 16, 16), (33, 17, 9)):
        shapes = {"second": (cols, depth), "first": (depth, rows), "stored": (cols, rows)}
        changed = shapes.get(function.__name__.split("_", maxsplit=1)[0])
        a = RNG.integers(-3, 4, changed if function is first_transposed else (rows, depth))
        b = RNG.integers(-3, 4, changed if function is second_transposed else (depth, cols))
        c = np.zeros(changed if function is stored_transposed else (rows, cols), np.float32)
        first, second = a.astype(np.float32), b.astype(np.float32)
        host = c.copy()
        kernel(first, second, host)
        for mode in ("auto", "gpu", "tpu-unified", "tpu-partitioned"):
            found = np.full_like(c, 7)
            vividc.simulate(in_mode(program, mode), first, second, found, fabric="vivid")
            np.testing.assert_array_equal(found, host, err_msg=f"{mode} {rows, cols, depth}")
    square = np.ones((4, 4), np.float32)
    for mode in ("auto", "gpu", "tpu-unified", "tpu-partitioned"):
        with pytest.raises(ArgumentError, match="arrays b and c overlap"):
            vividc.simulate(in_mode(program, mode), square.copy(), square, square, fabric="vivid")
