"""Ranges hold every value of their expressions, and none leaves 64 bits."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from tests.fuzz.values import (
    TYPES,
    Value,
    cast,
    constant,
    divided,
    either,
    odd,
    right,
    ring,
    shifted,
)

NAMES = {"np": np, "min": min, "max": max}
CORNERS = (0, 1, -1, 7, -8, 2**31 - 1, -(2**31), 2**62, -(2**63), 2**63 - 1)


def value(text: str, **variables: int) -> int:
    return int(eval(text, {**NAMES, **variables}))


@pytest.mark.parametrize("operator", ["+", "-", "*", "&", "|", "^"])
def test_rings_stay_in_their_range(operator: str) -> None:
    random = Random(operator)
    for _ in range(200):
        low, high = sorted(random.sample(CORNERS, 2))
        found = ring(operator, Value("a", low, high), constant(random.choice(CORNERS)))
        assert found.fits
        if "np." not in found.text:
            for a in (low, high, (low + high) // 2):
                assert found.low <= value(found.text, a=a) <= found.high


@pytest.mark.parametrize("operator", ["//", "%"])
@pytest.mark.parametrize("divisor", [1, -1, 3, -7, 255])
def test_quotients_stay_in_their_range(operator: str, divisor: int) -> None:
    for a in (-(2**31), -8, 0, 5, 2**31 - 1):
        found = divided(operator, Value("a", -(2**31), 2**31 - 1), constant(divisor))
        assert found.low <= value(found.text, a=a) <= found.high


def test_shifts_never_overflow() -> None:
    for amount in (0, 8, 31, 40):
        for low, high in TYPES.values():
            found = shifted(Value("a", low, high), amount)
            assert found.fits
            assert right(found, amount).fits


def test_a_cast_of_what_fits_keeps_its_range() -> None:
    assert cast(Value("a", 0, 7), "uint8") == Value("np.int64(np.uint8(a))", 0, 7)
    assert cast(Value("a", -1, 7), "uint8").high == 255


def test_a_divisor_is_not_zero() -> None:
    assert all(value(odd(Value("a", -9, 9)).text, a=a) != 0 for a in range(-9, 10))


def test_one_of_two_has_the_range_of_both() -> None:
    assert either("min({a}, {b})", Value("a", 0, 3), Value("b", -2, 1)) == Value("min(a, b)", -2, 3)
