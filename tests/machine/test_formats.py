"""Number formats: every code, and rounding against the nearest of all numbers."""

from __future__ import annotations

import math
import random
from bisect import bisect_left
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from tests.rounding import nearest
from vividc import formats
from vividc.formats import (
    E4M3,
    E5M2,
    F16,
    FORMATS,
    Format,
    join,
    round_array,
    round_bits,
    split,
    to_float,
    to_floats,
    values,
)

ALL = pytest.mark.parametrize("fmt", FORMATS.values(), ids=FORMATS)
DETAILS = {
    F16: (65504.0, 2.0**-14, 2.0**-24, 0x7BFF, 0x7C00, 0x7E00),
    E4M3: (448.0, 2.0**-6, 2.0**-9, 0x7E, None, 0x7F),
    E5M2: (57344.0, 2.0**-14, 2.0**-16, 0x7B, 0x7C, 0x7E),
}
"""Largest, smallest normal and smallest number, and their codes, as the OCP table has them."""


@ALL
def test_limits_are_the_published_ones(fmt: Format) -> None:
    largest, normal, smallest, code, infinity, nan = DETAILS[fmt]
    assert (fmt.max_finite, fmt.min_normal, fmt.min_subnormal) == (largest, normal, smallest)
    assert (fmt.max_code, fmt.infinity, fmt.nan) == (code, infinity, nan)
    assert fmt.saturates is (fmt is E4M3)
    assert fmt.lanes * fmt.bits == 32
    assert to_float(fmt, 1) == smallest
    assert to_float(fmt, round_bits(fmt, normal)) == normal


def test_codes_of_f16_are_numpys() -> None:
    codes = np.arange(1 << 16, dtype=np.uint16)
    np.testing.assert_array_equal(to_floats(F16, codes), codes.view(np.float16).astype(np.float32))


@pytest.mark.parametrize(("fmt", "field"), [(E4M3, 4), (E5M2, 5)])
def test_codes_of_fp8_by_their_fields(fmt: Format, field: int) -> None:
    for code in range(256):
        sign, exponent = code >> 7, code >> (7 - field) & (1 << field) - 1
        mantissa = code & (1 << (7 - field)) - 1
        bias, last = (7, 15) if fmt is E4M3 else (15, 31)
        value = to_float(fmt, code)
        if exponent == last and fmt is E5M2:
            assert math.isinf(value) if mantissa == 0 else math.isnan(value)
        elif code & 0x7F == 0x7F:
            assert math.isnan(value)
        else:
            implicit = Fraction(1 if exponent else 0)
            scale = Fraction(2) ** (max(exponent, 1) - bias)
            exact = (implicit + Fraction(mantissa, 1 << (7 - field))) * scale
            assert Fraction(value) == (-exact if sign else exact)
        if not math.isnan(value):
            assert math.copysign(1.0, value) == (-1.0 if sign else 1.0)


@ALL
def test_every_number_rounds_to_itself(fmt: Format) -> None:
    numbers = np.array(values(fmt))
    codes = np.arange(1 << fmt.bits)
    codes = np.where(np.isnan(numbers), fmt.nan, codes)
    assert [round_bits(fmt, number) for number in values(fmt)] == codes.tolist()
    assert round_array(fmt, numbers).tolist() == codes.tolist()
    assert round_array(fmt, numbers.astype(np.float32)).tolist() == codes.tolist()
    assert round_array(fmt, numbers).dtype == fmt.dtype


@ALL
def test_ties_and_their_neighbours(fmt: Format) -> None:
    """Between every two neighbours: the middle, and the binary64 numbers beside it."""
    positive = values(fmt)[: fmt.max_code + 1]
    middles = [(low + high) / 2 for low, high in pairwise(positive)]
    for code, middle in enumerate(middles):
        assert round_bits(fmt, middle) == code + (code & 1)
        assert round_bits(fmt, math.nextafter(middle, 0.0)) == code
        assert round_bits(fmt, math.nextafter(middle, math.inf)) == code + 1
        assert round_bits(fmt, -middle) == (code + (code & 1)) | fmt.sign
    beside = np.array([*middles, *(math.nextafter(middle, math.inf) for middle in middles)])
    assert round_array(fmt, beside).tolist() == [round_bits(fmt, x) for x in beside.tolist()]


@ALL
def test_too_large(fmt: Format) -> None:
    """From half a last place above the largest number on."""
    last = to_float(fmt, fmt.max_code) - to_float(fmt, fmt.max_code - 1)
    bound = fmt.max_finite + last / 2
    below = math.nextafter(bound, 0.0)
    beyond = fmt.max_code if fmt is E4M3 else fmt.infinity
    for number, code in ((below, fmt.max_code), (bound, beyond), (1e300, beyond)):
        assert round_bits(fmt, number) == code
        assert round_bits(fmt, -number) == code | fmt.sign
        assert round_bits(fmt, Fraction(number)) == code
    assert round_bits(fmt, math.inf) == beyond
    assert round_bits(fmt, -math.inf) == beyond | fmt.sign
    signalling = np.array([0x7F800001, 0xFFBFFFFF], np.uint32).view(np.float32)
    assert round_array(fmt, signalling).tolist() == [fmt.nan, fmt.nan]
    special = np.array([np.inf, -np.inf, np.nan, -np.nan, 0.0, -0.0, 1e300, 5e-324])
    expected = [beyond, beyond | fmt.sign, fmt.nan, fmt.nan, 0, fmt.sign, beyond, 0]
    assert round_array(fmt, special).tolist() == expected
    assert [round_bits(fmt, x) for x in special.tolist()] == expected


@ALL
def test_random_numbers_round_to_the_nearest(fmt: Format) -> None:
    rng = random.Random(1)
    low, high = math.frexp(fmt.min_subnormal)[1] - 4, math.frexp(fmt.max_finite)[1] + 3
    numbers = [rng.uniform(-1, 1) * 2.0 ** rng.randint(low, high) for _ in range(5000)]
    expected = [nearest(fmt, Fraction(number)) for number in numbers]
    assert [round_bits(fmt, number) for number in numbers] == expected
    assert [round_bits(fmt, Fraction(number)) for number in numbers] == expected
    assert round_array(fmt, np.array(numbers)).tolist() == expected


def test_f16_casts_are_numpys() -> None:
    words = np.random.default_rng(2).integers(0, 1 << 32, 100_000, np.uint32)
    words[::3] = words[::3] & np.uint32(0x87FFFFFF) | np.uint32(0x38000000)  # around 1
    numbers = words.view(np.float32)
    numbers = numbers[~np.isnan(numbers)]
    with np.errstate(over="ignore"):
        expected = numbers.astype(np.float16).view(np.uint16)
    np.testing.assert_array_equal(round_array(F16, numbers), expected)


def test_a_binary64_number_is_not_rounded_to_binary32_first() -> None:
    number = 288 + 2.0**-16  # binary32 has 288 only, halfway between 256 and 320
    assert to_float(E5M2, round_bits(E5M2, number)) == 320
    assert to_floats(E5M2, round_array(E5M2, np.array([number]))) == 320
    assert to_float(E5M2, round_bits(E5M2, 288)) == 256


def test_exact_ratios_round_once() -> None:
    tie = Fraction(2049)  # halfway between 2048 and 2050
    tiny = Fraction(1, 10**60)
    assert to_float(F16, round_bits(F16, tie)) == 2048
    assert to_float(F16, round_bits(F16, tie + tiny)) == 2050
    assert to_float(F16, round_bits(F16, -tie - tiny)) == -2050
    assert round_bits(F16, Fraction(0)) == 0
    assert round_bits(F16, Fraction(1, 3)) == 0x3555


@ALL
def test_a_word_is_its_lanes(fmt: Format) -> None:
    codes = tuple(range(1, fmt.lanes + 1))
    word = join(fmt, codes)
    assert split(fmt, word) == codes
    assert word & fmt.mask == 1
    assert join(fmt, codes[:1]) == 1


def test_the_oracle_knows_ties() -> None:
    positive = values(E4M3)[: E4M3.max_code + 1]
    at = bisect_left(positive, 1.0)
    middle = Fraction((positive[at] + positive[at + 1]) / 2)
    assert nearest(E4M3, middle) == at
    assert nearest(E4M3, middle + Fraction(1, 1 << 40)) == at + 1


@ALL
def test_nearest_numbers_are_those_of_the_codes(fmt: Format) -> None:
    rng = np.random.default_rng(6)
    bits = rng.integers(0, 1 << 32, 200_000, dtype=np.uint64).astype(np.uint32)
    every = to_floats(fmt, np.arange(1 << fmt.bits).astype(fmt.dtype))
    held = every[np.isfinite(every)]
    between = (np.sort(held)[:-1] / 2 + np.sort(held)[1:] / 2).astype(np.float32)
    some = [bits.view(np.float32), held, between, fmt.max_finite * np.array([1.03, 1.07, 2.0])]
    numbers = np.concatenate([part.astype(np.float32) for part in some])
    numbers = numbers[np.isfinite(numbers)]
    expected = to_floats(fmt, round_array(fmt, numbers))
    found = formats.nearest(fmt, numbers)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found.view(np.uint32), expected.view(np.uint32))
