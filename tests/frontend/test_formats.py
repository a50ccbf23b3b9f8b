"""float16 and float8 in kernels: plain Python, numba and the array agree to the bit."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

import vividc
from tests.frontend.format_kernels import (
    CODES,
    halves,
    on_codes,
    on_words,
    ordered,
    rounded,
    truths,
)
from vividc import lang
from vividc.formats import FORMATS, round_array, to_floats

CHUNK = 400


def _words(fmt: str) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of codes: specials with everything, and random ones."""
    mask = FORMATS[fmt].mask
    special = [0, 1, 2, FORMATS[fmt].max_code, FORMATS[fmt].nan, FORMATS[fmt].overflow, 0x38]
    special += [code | FORMATS[fmt].sign for code in special]
    rng = np.random.default_rng(3)
    a = np.concatenate([np.repeat(special, len(special)), rng.integers(0, mask + 1, 204)])
    b = np.concatenate([np.tile(special, len(special)), rng.integers(0, mask + 1, 204)])
    return a.astype(np.uint32)[:CHUNK], b.astype(np.uint32)[:CHUNK]


@pytest.mark.parametrize("fmt", FORMATS)
def test_plain_python_numba_and_the_array_agree(fmt: str) -> None:
    kernel = on_codes(fmt)
    a, b = _words(fmt)
    n = len(a)
    plain, host, array = (np.zeros(9 * n, np.uint32) for _ in range(3))
    kernel.py_func(a, b, plain, n)
    kernel(a, b, host, n)
    assert np.array_equal(plain, host)
    program = vividc.compile(
        kernel, loops=vividc.LoopOptions(auto=False), time_limit_s=10.0, effort="fast"
    )
    vividc.simulate(program, a, b, array, n)
    assert np.array_equal(host, array)


@pytest.mark.parametrize("fmt", ["e4m3", "e5m2"])
def test_every_pair_of_float8_codes_on_the_host(fmt: str) -> None:
    codes = np.arange(256, dtype=np.uint32)
    a, b = np.repeat(codes, 256), np.tile(codes, 256)
    out = np.zeros(9 * len(a), np.uint32)
    on_codes(fmt)(a, b, out, len(a))
    x, y = (to_floats(FORMATS[fmt], v.astype(np.uint8)).astype(np.float64) for v in (a, b))
    with np.errstate(invalid="ignore"):
        exact = (x + y, x - y, x * y, x * y + x)
    for column, numbers in enumerate(exact):
        assert np.array_equal(out[column::9], round_array(FORMATS[fmt], numbers))


@pytest.mark.parametrize("fmt", FORMATS)
def test_casts_round_once(fmt: str) -> None:
    rng = np.random.default_rng(5)
    values = to_floats(FORMATS[fmt], np.arange(FORMATS[fmt].mask, dtype=FORMATS[fmt].dtype))
    finite = np.sort(values[np.isfinite(values)])
    middles = (finite[:-1].astype(np.float64) + finite[1:]) / 2
    near = rng.choice(middles, 300).astype(np.float32)
    x = np.concatenate([near, np.nextafter(near, np.float32(9e9)), -near])
    x = np.concatenate([x, [np.nan, np.inf, -np.inf, 1e30, -1e-30, 0.0, -0.0]]).astype(np.float32)
    wanted = to_floats(FORMATS[fmt], round_array(FORMATS[fmt], x))
    kernel = rounded(fmt)
    host, array = np.zeros_like(x), np.zeros_like(x)
    kernel(x, host, len(x))
    program = vividc.compile(
        kernel, loops=vividc.LoopOptions(auto=False), time_limit_s=10.0, effort="fast"
    )
    vividc.simulate(program, x, array, len(x))
    for got in (host, array):
        assert np.array_equal(got, wanted, equal_nan=True)
        assert np.array_equal(np.signbit(got), np.signbit(wanted))


@pytest.mark.parametrize("fmt", FORMATS)
def test_words_of_lanes_are_packed_and_multiplied(fmt: str) -> None:
    rng = np.random.default_rng(11)
    lanes = FORMATS[fmt].lanes
    x = rng.standard_normal(24 * lanes).astype(np.float32) * np.exp2(
        rng.integers(-9, 9, 24 * lanes)
    )
    x = x.astype(np.float32)
    x[-2 * lanes : -2 * lanes + 2] = -0.0, np.nan
    wanted = round_array(FORMATS[fmt], x).view(np.uint32)
    lane_type = FORMATS[fmt].dtype
    rounded_x = to_floats(FORMATS[fmt], wanted.view(lane_type)).reshape(24, lanes)
    larger = np.fmax(rounded_x[:-1], rounded_x[1:]).ravel()
    results = []
    program = vividc.compile(
        on_words(fmt), loops=vividc.LoopOptions(auto=False), time_limit_s=10.0, effort="fast"
    )
    for run in (on_words(fmt).py_func, on_words(fmt), lambda *a: vividc.simulate(program, *a)):
        words, sums = np.zeros(24, np.uint32), np.zeros(23, np.float32)
        most = np.zeros(23, np.uint32)
        run(x, words, sums, most)
        assert np.array_equal(words, wanted)
        assert np.array_equal(to_floats(FORMATS[fmt], most.view(lane_type)), larger)
        results.append(sums)
    for got in results:
        assert np.array_equal(got.view(np.uint32), results[0].view(np.uint32))
    exact = x[:23] + np.sum(rounded_x[:-1].astype(np.float64) * rounded_x[1:], axis=1)
    assert np.allclose(results[0], exact, rtol=1e-5, atol=1e-5, equal_nan=True)


def test_arrays_of_float16() -> None:
    rng = np.random.default_rng(7)
    args: tuple[Any, ...] = (
        rng.standard_normal((5, 7)).astype(np.float16),
        rng.standard_normal(7).astype(np.float16),
        np.zeros(5, np.float32),
        np.zeros(5, np.uint8),
    )
    program = vividc.compile(halves, time_limit_s=5.0, effort="fast")
    host, array, reference = (copy.deepcopy(args) for _ in range(3))
    halves(*host)
    vividc.simulate(program, *array)
    vividc.simulate(program, *reference, engine="reference")
    for one, other, third in zip(host, array, reference, strict=True):
        assert one.tobytes() == other.tobytes() == third.tobytes()
    assert host[1].dtype == np.float16


def test_a_float16_is_a_condition() -> None:
    x = np.array([3, 0, -0.0, np.nan, np.inf, 6e-8], np.float16)
    host, array = np.zeros(len(x), np.int32), np.zeros(len(x), np.int32)
    truths(x, host)
    vividc.simulate(
        vividc.compile(
            truths, loops=vividc.LoopOptions(auto=False), time_limit_s=10.0, effort="fast"
        ),
        x,
        array,
    )
    assert host.tolist() == array.tolist() == [5, 2, 2, 5, 5, 5]


def test_a_sort_of_float16_has_nans_last() -> None:
    x = np.array([3, np.nan, 1, -2, np.nan, 0, -7], np.float16)
    wanted = np.sort(x)
    vividc.simulate(
        vividc.compile(
            ordered, loops=vividc.LoopOptions(auto=False), time_limit_s=10.0, effort="fast"
        ),
        x,
    )
    assert np.array_equal(x, wanted, equal_nan=True)


def test_a_fused_product_keeps_the_zero_that_ieee_asks_for() -> None:
    one, zero = lang.fp16(1.0), lang.fp16(0.0)
    assert lang.fma(one, -zero, zero).bits == 0
    assert lang.fma(one, -zero, -zero).bits == 0x8000
    assert lang.fma(one, one, -one).bits == 0


def test_numbers_of_two_formats_do_not_mix_in_plain_python() -> None:
    with pytest.raises(TypeError, match="cast"):
        lang.fp16(1.0) + lang.fp8(1.0)
    with pytest.raises(TypeError, match="cast"):
        _ = lang.fp16(1.0) < 1.0
    assert repr(lang.fp8(1.1)) == "fp8(1.125)"
    assert [float(number(0x38)) for number in CODES.values()] == [3.337860107421875e-06, 1.0, 0.5]
