"""The expansion of `fdiv`: correctly rounded normal quotients, special operands, and the proof."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from tests.dfg.expand.vectorised import (
    SPECIALS,
    by_semantics,
    expanded,
    fma,
    graph,
    interpreted,
    random_words,
)
from vividc.dfg.check import check
from vividc.dfg.expand.divide import NEWTON_STEPS, RECIPROCAL_MAGIC
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import Opcode
from vividc.machine.words import float_of, word_of

SMALLEST_NORMAL = 0x00800000
MAX_SUBNORMAL_ULP = Fraction(3, 4)
HARD_DIVISORS = 2


def is_subnormal(words: np.ndarray) -> np.ndarray:
    magnitude = words & np.uint32(0x7FFFFFFF)
    return (magnitude > 0) & (magnitude < SMALLEST_NORMAL)


def assert_rounded(a: np.ndarray, d: np.ndarray, ours: np.ndarray) -> None:
    """The table's word where that is no subnormal number, else within the bound."""
    exact = by_semantics(Opcode.FDIV, a, d)
    small = is_subnormal(exact) | is_subnormal(ours)
    assert np.array_equal(ours[~small], exact[~small])
    for x, y, word in zip(*(v[small].tolist() for v in (a, d, ours)), strict=True):
        quotient = Fraction(float_of(x)) / Fraction(float_of(y))
        error = abs(Fraction(float_of(word)) - quotient) * 2**149
        assert error <= MAX_SUBNORMAL_ULP, (hex(x), hex(y), hex(word))


def reciprocal(mantissas: np.ndarray) -> np.ndarray:
    """The sequence's 1/d for words of [1, 2)."""
    d = mantissas.view(np.float32)
    one = np.ones(1, np.float32)
    y = (np.uint32(RECIPROCAL_MAGIC) - mantissas).view(np.float32)
    for _ in range(NEWTON_STEPS):
        y = fma(y, fma(-d, y, one), y)
    error = fma(-d, y, one)
    return fma(y, fma(error, error, error), y)


def hardest(divisor: int) -> list[int]:
    """Dividends in [2**23, 2**24) whose quotients are 1/(2 divisor) ulp from a middle: solutions of
    2**(s+1) dividend - odd divisor = +-1.
    """
    dividends = []
    for scale in (24, 25):
        for distance in (1, -1):
            odd = -distance * pow(divisor, -1, 1 << scale) % (1 << scale)
            dividend = (odd * divisor + distance) >> scale
            if 1 << 23 <= dividend < 1 << 24 and 1 << 24 <= odd < 1 << 25:
                dividends.append(dividend)
    return dividends


def test_special_operands() -> None:
    a, d = (grid.ravel() for grid in np.meshgrid(SPECIALS, SPECIALS))
    ours = interpreted(Opcode.FDIV, a, d)
    assert_rounded(a, d, ours)
    assert np.array_equal(ours, expanded(Opcode.FDIV, a, d))


def test_random_operands() -> None:
    a, d = random_words(3000, 1), random_words(3000, 2)
    ours = interpreted(Opcode.FDIV, a, d)
    assert_rounded(a, d, ours)
    assert np.array_equal(ours, expanded(Opcode.FDIV, a, d))


def test_quotients_around_the_smallest_normal_and_the_largest_number() -> None:
    rng = np.random.default_rng(3)
    count = 2000
    d = rng.integers(0x3F000000, 0x40000000, 2 * count).astype(np.uint32)
    low = rng.integers(0x00000001, 0x01000000, count)
    high = rng.integers(0x7F000000, 0x7F800000, count)
    a = np.concatenate([low, high]).astype(np.uint32)
    assert_rounded(a, d, expanded(Opcode.FDIV, a, d))


@pytest.mark.parametrize("divisor", [0x3F7FFFFF, 0x3F7FFFFD, 0x3F7FFFFB, 0x3F7FFFF9])
def test_the_hardest_quotients(divisor: int) -> None:
    mantissa = divisor & 0x7FFFFF | 0x800000
    dividends = [word_of(float(dividend)) for dividend in hardest(mantissa)]
    assert dividends
    a = np.array(dividends, np.uint32)
    d = np.full(len(dividends), divisor, np.uint32)
    assert np.array_equal(expanded(Opcode.FDIV, a, d), by_semantics(Opcode.FDIV, a, d))


def test_operations() -> None:
    after = expand_math(graph(Opcode.FDIV, 1))
    assert check(after) == []
    assert len(after.operations) == 3 + 47


@pytest.mark.slow
def test_every_divisor_is_correctly_rounded() -> None:
    """The reciprocal's relative error times the last residual, half an ulp and 2**-20 of one at
    most, must stay below 1/(2d) ulp; where it does not, the dividends of that distance are tried.
    """
    mantissas = np.arange(0x3F800000, 0x40000000, dtype=np.uint32)
    d = mantissas.view(np.float32).astype(np.float64)
    reach = np.abs(1 - d * reciprocal(mantissas)) * d * 2**23  # in units of 1/(2d) ulp
    hard = mantissas[reach >= 1 - 2.0**-19]
    assert len(hard) == HARD_DIVISORS
    assert reach.max() < 2  # only distance 1 is in reach: distances are integers
    for word in hard.tolist():
        dividends = hardest(word & 0x7FFFFF | 0x800000)
        a = np.array([word_of(float(dividend)) for dividend in dividends], np.uint32)
        divisors = np.full(len(a), word, np.uint32)
        assert np.array_equal(
            expanded(Opcode.FDIV, a, divisors), by_semantics(Opcode.FDIV, a, divisors)
        )


@pytest.mark.slow
def test_a_dense_sweep_equals_numpy() -> None:
    for seed in range(8):
        a, d = random_words(1 << 20, 2 * seed), random_words(1 << 20, 2 * seed + 1)
        ours = expanded(Opcode.FDIV, a, d)
        with np.errstate(all="ignore"):
            quotient = a.view(np.float32) / d.view(np.float32)
        exact = np.where(np.isnan(quotient), np.uint32(0x7FC00000), quotient.view(np.uint32))
        normal = ~(is_subnormal(exact) | is_subnormal(ours))
        assert np.array_equal(ours[normal], exact[normal])
        assert np.abs(ours.astype(np.int64) - exact)[~normal].max() <= 1
