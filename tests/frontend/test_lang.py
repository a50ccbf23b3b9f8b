"""`vividc.lang`: the plain functions, and numba's, on the values where they could differ."""

from __future__ import annotations

from fractions import Fraction

import numba
import numpy as np
import pytest

from vividc import lang

INTS = [0, 1, -1, 2**31 - 1, -(2**31), 65537, -65536, 2**32 - 1, 12345678]
FLOATS = [0.0, -0.0, 1.0, -1.5, 1e-38, 1e-45, 3e38, -3e38, np.inf, -np.inf, 1 + 2**-23, 0.1]


@numba.njit
def high(a, b):
    return lang.mulhi(a, b), lang.mulhi_u(a, b)


@numba.njit
def fused(a, b, c):
    return lang.fma(a, b, c)


@numba.njit
def bits(value, word):
    return lang.bitcast_i32(value), lang.bitcast_f32(word)


@pytest.mark.parametrize("a", INTS)
def test_high_products(a: int) -> None:
    for b in INTS:
        signed, unsigned = lang.mulhi(a, b), lang.mulhi_u(a, b)
        assert (signed, unsigned) == high(a, b)
        low = np.int64(np.int32(np.uint32(a & 0xFFFFFFFF).view(np.int32)))
        other = np.int64(np.uint32(b & 0xFFFFFFFF).view(np.int32))
        assert signed == (low * other) >> 32
        assert int(unsigned) == ((a & 0xFFFFFFFF) * (b & 0xFFFFFFFF)) >> 32


def test_fma_rounds_once() -> None:
    values = [np.float32(value) for value in FLOATS]
    rng = np.random.default_rng(5)
    words = rng.integers(0, 2**32, (400, 3), dtype=np.uint32)
    triples = [tuple(row) for row in words.view(np.float32)]
    triples += [(a, b, c) for a in values for b in values for c in values]
    for a, b, c in triples:
        ours, theirs = lang.fma(a, b, c), np.float32(fused(a, b, c))
        assert _word(ours) == _word(theirs) or (np.isnan(ours) and np.isnan(theirs)), (a, b, c)


def test_fma_of_a_tie_is_not_rounded_twice() -> None:
    a, c = np.float32(1 + 2**-12), np.float32(2**-60)
    exact = Fraction(float(a)) ** 2 + Fraction(float(c))
    assert abs(Fraction(float(lang.fma(a, a, c))) - exact) < Fraction(1, 2**24)
    assert lang.fma(a, a, c) > lang.fma(a, a, -c)


@pytest.mark.parametrize("value", FLOATS)
def test_bits(value: float) -> None:
    word = lang.bitcast_i32(value)
    assert int(word) & 0xFFFFFFFF == _word(np.float32(value))
    assert _word(lang.bitcast_f32(word)) == _word(np.float32(value))
    assert bits(np.float32(value), word) == (word, lang.bitcast_f32(word))


def _word(value: np.float32) -> int:
    return int(np.float32(value).view(np.uint32))
