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
from vividc.gemm.kernels.choice import KernelChoice, choose_for, explain
from vividc.gemm.kernels.sequence import Launch
from vividc.gemm.passes import with_arrays
from vividc.program import Program

RNG = np.random.default_rng(5)
VIVID = with_arrays(arch.load_accelerator("vivid"))

Matrix = NDArray[np.float32]


def random(*shape: int) -> Matrix:
    return RNG.standard_normal(shape).astype(np.float32)


LAYER = "void(float32[:, ::1], float32[:, ::1], float32[::1], float32[:, ::1])"


def layer_over_prange(a, w, bias, c):
    for i in prange(a.shape[0]):
        for j in range(w.shape[0]):
            total = bias[j]
            for k in range(a.shape[1]):
                total += a[i, k] * w[j, k]
            c[i, j] = max(total, np.float32(0))


@vividc.kernel(LAYER)
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
    assert program.products is not None
    return replace(program, products=replace(program.products, mode=mode))


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
    assert vividc.load(tmp_path / "layer.vivid").products == program.products


def chosen(program: Program, *args: Matrix) -> KernelChoice:
    """The mode of a launch with these arrays, all parameters."""
    assert program.products is not None
    names = [param.name for param in program.params]
    arrays = dict(zip(names, args, strict=True))
    words = {
        f"{name}.shape{n}": size for name, x in arrays.items() for n, size in enumerate(x.shape)
    }
    return choose_for(program, Launch(program.products, arrays, words), VIVID)


@pytest.fixture(scope="module")
def automatic() -> Program:
    return vividc.compile(layer, fabric="vivid", loops=vividc.LoopOptions(auto=False))


def test_auto_takes_the_mode_with_fewest_cycles(automatic: Program) -> None:
    small, large = (
        chosen(automatic, *arguments(4, 4, 4)),
        chosen(automatic, *arguments(4096, 64, 64)),
    )
    assert small.mode == "gpu"
    assert large.mode == "tpu-unified"
    assert set(large.cycles) == {"gpu", "tpu-unified", "tpu-partitioned"}
    a, w, bias, c = arguments(3, 2, 2)
    result = vividc.simulate(automatic, a, w, bias, c, fabric="vivid")
    assert {event.program for event in result.events if event.kind == "run"} == {"layer"}


def test_a_layer_of_known_sizes_takes_the_mode_that_one_of_unknown_sizes_takes() -> None:
    """With known sizes the tiles' estimate saw neither stalls in banks nor starts of loops nor the
    configuration, and a dense layer of 256x32x48 ran on the tiles, in 31,258 cycles, not 14,474.
    """
    args = arguments(256, 32, 48)
    kernel = vividc.kernel(LAYER)(layer_over_prange)
    known = vividc.compile(kernel, fabric="vivid", loops=vividc.LoopOptions(auto=False), like=args)
    choice = chosen(known, *args)
    assert choice.mode != "gpu"
    measured = vividc.simulate(in_mode(known, "gpu"), *args, fabric="vivid").cycles
    assert choice.cycles["gpu"] == pytest.approx(measured, rel=0.15)


def test_explain_says_why(program: Program, automatic: Program) -> None:
    text = explain(automatic, VIVID)
    assert text.startswith("matrix product c = max(a w^T + bias, 0): 4096x64 by 64x64: mode tpu-")
    assert "fewest cycles predicted: gpu (1 tile)" in text
    assert "asked for" in explain(program, VIVID)


def test_sums_that_may_be_no_numbers_are_made_positive_on_the_tiles(program: Program) -> None:
    a, w, bias, c = arguments(20, 3, 5)
    a[3, 2], w[1, 0] = np.nan, np.inf
    tiles = np.zeros_like(c)
    vividc.simulate(in_mode(program, "gpu"), a, w, bias, tiles, fabric="vivid")
    vividc.simulate(program, a, w, bias, c, fabric="vivid")
    np.testing.assert_array_equal(c, tiles)


def test_loops_over_more_than_an_array_are_told(program: Program) -> None:
    a, w, bias, c = arguments()
    with pytest.raises(ArgumentError, match="run over more than c, 49x9"):
        vividc.simulate(program, a, w, bias, np.zeros((49, 9), np.float32), fabric="vivid")
    with pytest.raises(ArgumentError, match="run over more than bias, 8"):
        vividc.simulate(program, a, w, random(8), c, fabric="vivid")
    empty = (random(0, 5), w, bias, np.zeros((0, 9), np.float32))
    with pytest.raises(ArgumentError, match="nothing to compute"):
        vividc.simulate(program, *empty, fabric="vivid")


def test_modes_that_are_not_possible() -> None:
    with pytest.raises(ArgumentError, match="unknown mode 'tpu'"):
        vividc.compile(layer, fabric="vivid", mode="tpu")
    with pytest.raises(KernelError, match="mode tpu-unified: no loop adds products to sums"):
        vividc.compile(doubled, fabric="vivid", mode="tpu-unified")
    with pytest.raises(KernelError, match="the fabric is one tile"):
        vividc.compile(layer, mode="tpu-unified")
    with pytest.raises(KernelError, match="--no-contract forbids"):
        vividc.compile(layer, fabric="vivid", mode="tpu-unified", contract=False)


def test_an_inner_dimension_that_fits_no_memory_is_cut_and_sums_go_on(program: Program) -> None:
    a, w, bias, c = random(4, 600), random(3, 600), random(3), np.zeros((4, 3), np.float32)
    tiles = np.zeros_like(c)
    vividc.simulate(in_mode(program, "gpu"), a, w, bias, tiles, fabric="vivid")
    vividc.simulate(program, a, w, bias, c, fabric="vivid")
    np.testing.assert_array_equal(c, tiles)


def test_a_run_past_the_cycle_limit_is_told(program: Program) -> None:
    a, w, bias, c = arguments()
    with pytest.raises(SimulationError, match="after 50 cycles"):
        vividc.simulate(program, a, w, bias, c, fabric="vivid", cycle_limit=50)
    assert not c.any()


def test_an_observer_watches_one_tile(program: Program) -> None:
    with pytest.raises(ArgumentError, match="observer"):
        vividc.simulate(program, *arguments(), fabric="vivid", observer=lambda *seen: None)


SQUARE = "void(float32[:, ::1], float32[:, ::1], float32[:, ::1])"
SCALED = "void(float32, float32, float32[:, ::1], float32[:, ::1], float32[:, ::1])"


def scaled(alpha, beta, a, b, c):
    for i in range(c.shape[0]):
        for j in range(c.shape[1]):
            c[i, j] *= beta
        for k in range(a.shape[1]):
            for j in range(c.shape[1]):
                c[i, j] += alpha * a[i, k] * b[k, j]


def scaled_at_the_end(alpha, beta, a, b, c):
    for i in range(c.shape[0]):
        for j in range(c.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1] - 1, -1, -1):
                total += a[i, k] * b[k, j]
            c[i, j] = alpha * total + beta * c[i, j]


def lower_half(alpha, beta, a, b, c):
    for i in range(a.shape[0]):
        for j in range(i + 1):
            c[i, j] = c[i, j] * beta + alpha
        for k in range(a.shape[1]):
            for j in range(i + 1):
                c[i, j] -= a[i, k] * a[j, k]


def twice(alpha, beta, a, b, c):
    """The right operand, and what is added to, are results."""
    for i in range(c.shape[0]):
        for j in range(c.shape[1]):
            c[i, j] = np.float32(0)
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * b[k, j]
    for k in range(a.shape[0]):
        for i in range(b.shape[0]):
            for j in range(c.shape[1]):
                b[i, j] += a[k, i] * c[k, j]


def symmetric(alpha, beta, a, b, c):
    """Both sides of the diagonal are made of one, which keeps what it had."""
    for i in range(c.shape[0]):
        for j in range(i + 1, c.shape[0]):
            c[i, j] = np.float32(0)
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * a[j, k]
            c[i, j] /= beta - alpha
            c[j, i] = c[i, j]


ORDERED = (scaled, scaled_at_the_end, lower_half, symmetric, twice)


@pytest.mark.slow
@pytest.mark.parametrize("function", ORDERED, ids=lambda function: function.__name__)
@pytest.mark.parametrize("sizes", [(3, 2, 5), (17, 19, 9), (8, 24, 16)], ids=str)
def test_all_modes_give_the_same_bits(
    function: Callable[..., None], sizes: tuple[int, int, int]
) -> None:
    """Floats, whose sums depend on their order."""
    kernel = vividc.kernel(SCALED)(function)
    rows, cols, depth = sizes
    a, b = random(rows, depth), random(depth, cols)
    c = random(rows, rows if function in (lower_half, symmetric) else cols)
    args = (np.float32(1.5), np.float32(-0.7), a, b, c)
    program = vividc.compile(kernel, fabric="vivid", loops=vividc.LoopOptions(auto=False))
    host = [x.copy() for x in args]
    kernel(*host)
    runs = {}
    for mode in ("gpu", "tpu-partitioned"):
        runs[mode] = [x.copy() for x in args]
        vividc.simulate(in_mode(program, mode), *runs[mode], fabric="vivid")
        for found, wanted in zip(runs[mode][2:], host[2:], strict=True):
            np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-4)
    for found, wanted in zip(*(run[2:] for run in runs.values()), strict=True):
        np.testing.assert_array_equal(found, wanted)


def test_what_fits_no_tile_runs_on_the_arrays() -> None:
    """80x80 needs 75 KiB, and a tile has 32."""
    kernel = vividc.kernel(SCALED)(scaled)
    program = vividc.compile(kernel, fabric="vivid", loops=vividc.LoopOptions(auto=False))
    a, b, c = (RNG.integers(-3, 4, (80, 80)).astype(np.float32) for _ in range(3))
    wanted = 2 * a @ b + c
    result = vividc.simulate(program, np.float32(2), np.float32(1), a, b, c, fabric="vivid")
    np.testing.assert_array_equal(c, wanted)
    assert result.cycles < 30_000


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
