"""Kernels with `prange` over all tiles, against numba."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba import prange

import vividc
from vividc.errors import ArgumentError, VividcWarning
from vividc.launch import SpreadOptions, spread


@vividc.kernel("void(int32[::1], int32[::1])")
def scale(x, y):
    for i in prange(x.shape[0]):
        y[i] = 3 * x[i]


@vividc.kernel("void(int32[::1], int32[::1])")
def same_bank(x, y):
    for i in prange(y.shape[0]):
        y[i] = x[8 * i] + x[8 * i + 8]


@vividc.kernel("void(float32[::1], float32[::1], float32, int64)")
def saxpy(x, y, a, n):
    for i in prange(n):
        y[i] += a * x[i]


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def laplace(x, y):
    for i in prange(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            around = x[i - 1, j] + x[i + 1, j] + x[i, j - 1] + x[i, j + 1]
            y[i, j] = around - np.float32(4) * x[i, j]


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def gemv(a, x, y):
    for i in prange(a.shape[0]):
        total = np.float32(0)
        for j in range(a.shape[1]):
            total += a[i, j] * x[j]
        y[i] = total


@vividc.kernel("void(int32[::1], float32[:, ::1], float32[:, ::1])")
def lookup(index, table, out):
    for i in prange(index.shape[0]):
        row = index[i]
        for k in range(3):
            out[i, k] = table[row, k]


@vividc.kernel("void(uint8[:, ::1], uint8[:, ::1], int32)")
def threshold(image, out, limit):
    for i in prange(image.shape[0]):
        for j in range(image.shape[1]):
            out[i, j] = 255 if image[i, j] > limit else image[i, j] >> 1


@vividc.kernel("void(float32[::1], float32[::1])")
def clamped_stencil(x, y):
    n = len(x)
    for i in prange(n):
        total = x[max(i - 1, 0)]
        if i < n - 1:
            total += x[i + 1]
        y[i] = total


@vividc.kernel("void(float32[::1], float32[::1], int32[:, ::1])")
def mark_spans(first, last, out):
    """Both ends are pixels of the span, which is cut off at the borders."""
    for i in prange(out.shape[0]):
        left = max(np.int32(first[i]), 0)
        right = min(np.int32(last[i]), out.shape[1] - 1)
        for j in range(left, right + 1):
            out[i, j] += 1


@vividc.kernel("int32(int32[:, ::1], int32)")
def count_above(x, limit):
    found = np.int32(7)
    for i in numba.prange(x.shape[0]):
        for j in range(x.shape[1]):
            if x[i, j] > limit:
                found += 1
    return found


@vividc.kernel("float32(float32[::1])")
def largest(x):
    best = np.float32(-1e30)
    for i in prange(len(x)):
        best = max(best, x[i])
    return best


@vividc.kernel("float32(float32[::1], float32)")
def total(x, start):
    result = np.float32(1.5)
    for i in prange(len(x)):
        result -= x[i]
    return result


@vividc.kernel("int64(int32[::1], int64)")
def wide_total(x, start):
    result = start
    for i in prange(len(x)):
        if x[i] > 7:
            result += 3 * x[i]
        result -= x[i] & 255
    return result


@vividc.kernel("int64(int32[::1])")
def wide_least(x):
    best = 5
    for i in prange(len(x)):
        best = min(best, x[i])
    return best


@vividc.kernel("int64(uint8[::1])")
def bytes_total(x):
    result = 0
    for i in prange(len(x)):
        result += x[i]
    return result


@vividc.kernel("int32(uint8[::1])")
def least_byte(x):
    best = np.int32(300)
    for i in prange(len(x)):
        best = min(best, np.int32(x[i]))
    return best


@vividc.kernel("int64(uint8[:, ::1])")
def count_bytes(x):
    found = 0
    for i in prange(len(x)):
        for j in range(x.shape[1]):
            if x[i, j] > 100:
                found += 1
    return found


@vividc.kernel("void(float32[:, ::1], float32[:, :, ::1], float32[:, :, ::1], int32)")
def blend(blobs, centres, out, count):
    """Blocks of pixels; every block goes through all blobs, front to back."""
    for block in prange(out.shape[0]):
        for pixel in range(out.shape[1]):
            x, y = centres[block, pixel, 0], centres[block, pixel, 1]
            light = np.float32(1)
            colour = np.float32(0)
            for k in range(count):
                dx, dy = blobs[k, 0] - x, blobs[k, 1] - y
                alpha = max(blobs[k, 2] - dx * dx - dy * dy, np.float32(0))
                colour += light * alpha * blobs[k, 3]
                light *= np.float32(1) - alpha
            out[block, pixel, 0] = colour
            out[block, pixel, 1] = light


RNG = np.random.default_rng(5)


def floats(*shape: int) -> Any:
    return RNG.standard_normal(shape).astype(np.float32)


def pixels(blocks: int) -> Any:
    return np.zeros((blocks, 16, 2), np.float32)


def ints(high: int, *shape: int, dtype: Any = np.int32) -> Any:
    return RNG.integers(0, high, shape).astype(dtype)


CASES: list[tuple[Any, Callable[[], tuple[Any, ...]]]] = [
    (scale, lambda: (ints(1 << 30, 20_000), np.zeros(20_000, np.int32))),
    (scale, lambda: (ints(9, 3), np.zeros(3, np.int32))),
    (scale, lambda: (ints(9, 0), np.zeros(0, np.int32))),
    (same_bank, lambda: (ints(99, 8 * 3000 + 8), np.zeros(3000, np.int32))),
    (saxpy, lambda: (floats(18_000), floats(18_000), 0.5, 17_001)),
    (saxpy, lambda: (floats(10), floats(10), 0.5, -3)),
    (laplace, lambda: (floats(90, 120), floats(90, 120))),
    (laplace, lambda: (floats(2, 5), floats(2, 5))),
    (gemv, lambda: (floats(50, 300), floats(300), floats(50))),
    (lookup, lambda: (ints(400, 3000), floats(400, 3), floats(3000, 3))),
    (threshold, lambda: (ints(256, 77, 131, dtype=np.uint8), np.zeros((77, 131), np.uint8), 100)),
    (clamped_stencil, lambda: (floats(5000), floats(5000))),
    (mark_spans, lambda: (50 * floats(90), 50 + 60 * floats(90), ints(9, 90, 120))),
    (count_above, lambda: (ints(100, 90, 100), 50)),
    (largest, lambda: (floats(20_000),)),
    (wide_total, lambda: (ints(1 << 31, 5000), -(1 << 40))),
    (wide_least, lambda: (ints(1 << 20, 5000) - (1 << 19),)),
    (wide_least, lambda: (ints(1 << 20, 5000) + 9,)),
    (bytes_total, lambda: (ints(256, 5000, dtype=np.uint8),)),
    (least_byte, lambda: (ints(256, 5000, dtype=np.uint8) | 8,)),
    (count_bytes, lambda: (ints(256, 90, 100, dtype=np.uint8),)),
    (total, lambda: (floats(20_000), 0.0)),
    (blend, lambda: (RNG.random((9, 4)).astype(np.float32), floats(20, 16, 2), pixels(20), 9)),
]


@pytest.fixture(scope="module")
def programs() -> Callable[[Any], vividc.Program]:
    made: dict[str, vividc.Program] = {}

    def program(kernel: Any) -> vividc.Program:
        if kernel.name not in made:
            made[kernel.name] = vividc.compile(
                kernel, fabric="vivid", time_limit_s=6, effort="fast"
            )
        return made[kernel.name]

    return program


def copies(args: tuple[Any, ...]) -> list[Any]:
    return [a.copy() if isinstance(a, np.ndarray) else a for a in args]


@pytest.mark.parametrize(
    "case", CASES, ids=[f"{kernel.name}-{n}" for n, (kernel, _) in enumerate(CASES)]
)
def test_all_tiles_give_what_numba_gives(case: Any, programs: Any) -> None:
    kernel, make = case
    args = make()
    expected, got = copies(args), copies(args)
    value = kernel(*expected)
    result = vividc.simulate(programs(kernel), *got, fabric="vivid")
    for name, one, other in zip(kernel.py_func.__code__.co_varnames, expected, got, strict=False):
        if isinstance(one, np.ndarray):
            # Contracted multiplications and our exp differ from numba's in the last bits.
            np.testing.assert_allclose(other, one, rtol=1e-5, atol=1e-5, err_msg=name)
    if value is not None:
        # The sum of 20,000 floats depends on its order: their sizes times half an ulp of the sum.
        is_exact = isinstance(value, int)
        assert result.value == (value if is_exact else pytest.approx(value, rel=1e-4))
    for tile in result.stats["tiles"]:
        assert sum(tile["cycles"].values()) + sum(tile["stalls"].values()) == result.cycles


@pytest.mark.parametrize("kernel", [laplace, gemv, count_above, largest], ids=lambda k: k.name)
def test_one_tile_and_any_chunk_length_give_the_same_bits(kernel: Any, programs: Any) -> None:
    small: dict[str, tuple[Any, ...]] = {
        "laplace": (floats(20, 30), floats(20, 30)),
        "gemv": (floats(20, 30), floats(30), floats(20)),
        "count_above": (ints(9, 20, 30), 4),
        "largest": (floats(100),),
    }
    program = programs(kernel)
    args = small[kernel.name]
    alone = copies(args)
    expected = vividc.simulate(program, *alone, fabric=program.fabric)
    for chunk in (1, 7, 100):
        got = copies(args)
        result = spread(program, got, {}, "vivid", SpreadOptions(chunk=chunk)).simulate()
        assert result.value == expected.value
        for one, other in zip(alone, got, strict=True):
            assert not isinstance(one, np.ndarray) or one.tobytes() == other.tobytes()


def test_a_bundle_keeps_the_parallel_loop(tmp_path: Path, programs: Any) -> None:
    program = programs(count_above)
    program.save(tmp_path / "p.vivid")
    loaded = vividc.load(tmp_path / "p.vivid")
    assert loaded == program
    x = ints(100, 64, 90)
    assert vividc.simulate(loaded, x, 50, fabric="vivid").value == count_above(x, 50)


def test_a_kernel_without_prange_runs_on_one_tile() -> None:
    from tests.launch.kernels import program as compiled  # noqa: PLC0415
    from tests.launch.kernels import total as plain  # noqa: PLC0415

    x = ints(100, 1000)
    result = vividc.simulate(compiled(plain), x, fabric="vivid")
    assert result.value == x.sum()
    assert [tile["tile"] for tile in result.stats["tiles"]] == [0]
    with pytest.raises(
        ArgumentError, match=r"needs 400\d\d bytes of a scratchpad of 32768"
    ) as error:
        vividc.simulate(compiled(plain), ints(100, 10_000), fabric="vivid")
    assert "prange" in str(error.value)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def transpose(x, y):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            y[j, i] = x[i, j]


@vividc.kernel("void(int32[::1], int32[::1])")
def histogram(x, bins):
    for i in prange(len(x)):
        bins[x[i]] += 1


@vividc.kernel("void(int32[::1])")
def running(x):
    for i in prange(1, len(x)):
        x[i] += x[i - 1]


@pytest.mark.parametrize(
    ("kernel", "make"),
    [
        (transpose, lambda: (floats(40, 40), floats(40, 40))),
        (histogram, lambda: (ints(10, 100), np.zeros(10, np.int32))),
        (running, lambda: (ints(10, 100),)),
    ],
    ids=lambda item: getattr(item, "name", ""),
)
def test_chunks_that_meet_run_on_one_tile_with_a_warning(
    kernel: Any, make: Any, programs: Any
) -> None:
    args = make()
    expected = copies(args)
    kernel(*expected)
    with pytest.warns(VividcWarning, match="one tile only.*the same bytes") as told:
        result = vividc.simulate(programs(kernel), *args, fabric="vivid")
    assert "test_prange.py:" in str(told[0].message)
    assert len(result.stats["tiles"]) == 1
    assert all((a == b).all() for a, b in zip(args, expected, strict=True))


def test_chunks_that_meet_and_do_not_fit_one_tile_are_refused(programs: Any) -> None:
    args = (ints(10, 20_000), np.zeros(10, np.int32))
    with pytest.raises(ArgumentError, match="the same bytes") as error:
        vividc.simulate(programs(histogram), *args, fabric="vivid")
    assert "test_prange.py:" in str(error.value)
    assert not args[1].any()


def test_a_table_that_does_not_fit_is_refused_with_its_size(programs: Any) -> None:
    args = (ints(9, 100), floats(4000, 3), floats(100, 3))
    with pytest.raises(ArgumentError, match="table 48000 whole") as error:
        vividc.simulate(programs(lookup), *args, fabric="vivid")
    assert "table" in str(error.value).split("hint:")[1]


def test_a_row_that_does_not_fit_runs_in_blocks(programs: Any) -> None:
    x, out = floats(10, 9000), floats(10, 9000)
    expected = out.copy()
    laplace.py_func(x, expected)
    vividc.simulate(programs(laplace), x, out, fabric="vivid")
    np.testing.assert_allclose(out, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.slow
def test_gaussian_blending_over_the_rows_of_a_block() -> None:
    """The kernel of `kernels/gs_blend.py` with `prange` over rows; a mapping of a minute."""
    from kernels.gs_blend import gs_blend  # noqa: PLC0415
    from kernels.threads import gs_blend_rows  # noqa: PLC0415

    count, width, height = 40, 24, 16
    mean = RNG.random((2, count)).astype(np.float32) * width
    conic = np.stack([RNG.random(count), np.zeros(count), RNG.random(count)]).astype(np.float32)
    shades = RNG.random((4, count)).astype(np.float32)
    out = np.zeros(4 * width * height, np.float32)
    expected = out.copy()
    arrays = [*mean.copy(), *conic.copy(), *shades.copy()]
    sizes = (0, 0, width, height, count)
    gs_blend(*arrays, expected, *sizes)
    program = vividc.compile(gs_blend_rows, fabric="vivid", effort="fast", time_limit_s=60)
    arrays = [np.ascontiguousarray(array) for array in arrays]
    result = vividc.simulate(program, *arrays, out, *sizes, fabric="vivid")
    # Our exp is within 2 ulp, and multiplications and additions are contracted.
    np.testing.assert_allclose(out, expected, rtol=1e-4, atol=1e-5)
    assert len(result.stats["tiles"]) == 16


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def sometimes(x, y, limit):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            if x[i, j] > limit:
                y[i, j] = x[i, j]


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def evens(x, y, limit):
    for i in prange(x.shape[0]):
        for j in range(0, x.shape[1], 2):
            y[i, j] = x[i, j] + limit


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def always(x, y, limit):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i, j] + limit


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def stops(x, y, limit):
    for i in prange(x.shape[0]):
        for j in range(x.shape[1]):
            if x[i, j] < limit:
                break
            y[i, j] = x[i, j]


@pytest.mark.parametrize(
    ("kernel", "arrays_moved_in"),
    [(sometimes, 2), (evens, 2), (always, 1), (stops, 2)],
    ids=lambda item: getattr(item, "name", None),
)
def test_only_what_is_written_as_a_whole_is_not_moved_in(
    kernel: Any, arrays_moved_in: int, programs: Any
) -> None:
    x, y = ints(100, 32, 12), ints(100, 32, 12)
    expected = y.copy()
    kernel(x, expected, 20)
    result = vividc.simulate(programs(kernel), x, y, 20, fabric="vivid")
    assert (y == expected).all()
    assert result.stats["steps"]["move in"] == arrays_moved_in * result.stats["runs"]
