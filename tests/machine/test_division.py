"""Division by constants: exact for every divisor and range, and as short as promised."""

from __future__ import annotations

import random

import pytest

from vividc.machine.division import multiplier, quotient_by_constant, remainder_by_constant
from vividc.machine.opcodes import Opcode
from vividc.machine.semantics import evaluate

LARGEST = (1, 9, 100, 255, 1023, 65535, 10**6, 2**24, 2**30, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1)
FACTORS = (3, 5, 17, 257, 65537)  # of 2**32 - 1


class Words:
    """Evaluates what is written, and counts it."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, opcode: Opcode, *operands: int) -> int:
        self.count += 1
        return evaluate(opcode, operands)


def dividends(divisor: int, largest: int, count: int) -> list[int]:
    """The ends, and the neighbours of random multiples: where a quotient steps."""
    source = random.Random(divisor * 31 + largest)
    steps = [divisor * source.randint(0, largest // divisor) for _ in range(count)]
    near = [step + offset for step in (*steps, largest // divisor * divisor) for offset in (-1, 0)]
    return [n for n in (0, 1, largest - 1, largest, *near) if 0 <= n <= largest]


def assert_exact(divisor: int, largest: int, count: int = 6) -> None:
    for n in dividends(divisor, largest, count):
        words = Words()
        assert quotient_by_constant(words, n, divisor, largest) == n // divisor, (n, divisor)
        assert words.count <= 4
        words = Words()
        assert remainder_by_constant(words, n, divisor, largest) == n % divisor, (n, divisor)
        assert words.count <= 6


@pytest.mark.parametrize("largest", LARGEST)
def test_small_and_special_divisors(largest: int) -> None:
    powers = [2**k + step for k in range(1, 32) for step in (-1, 0, 1)]
    for divisor in (*range(1, 130), *powers, 2**32 - 1):
        assert_exact(divisor, largest)


def test_divisors_of_the_largest_word_need_no_increment() -> None:
    """A dividend of 2**32 - 1 is not incremented: its quotient must be the one below's."""
    divisors = {1}
    for factor in FACTORS:
        divisors |= {divisor * factor for divisor in divisors}
    for divisor in divisors - {1}:
        assert not multiplier(divisor, 2**32 - 1).increment
        assert_exact(divisor, 2**32 - 1)


def test_random_divisors_and_ranges() -> None:
    source = random.Random(1)
    for _ in range(800):
        divisor = source.getrandbits(source.randint(1, 32)) or 1
        largest = source.getrandbits(source.randint(1, 32)) or 1
        assert_exact(divisor, largest, 3)


@pytest.mark.slow
def test_more_divisors() -> None:
    source = random.Random(2)
    for divisor in (*range(1, 10_000), *(source.randint(1, 2**32 - 1) for _ in range(20_000))):
        assert_exact(divisor, 2**32 - 1, 2)


def test_every_dividend_of_a_small_range() -> None:
    for largest in (100, 255, 1000):
        for divisor in range(1, largest + 2):
            for n in range(0, largest + 1, 7):
                assert quotient_by_constant(Words(), n, divisor, largest) == n // divisor
                assert remainder_by_constant(Words(), n, divisor, largest) == n % divisor


@pytest.mark.parametrize(
    ("divisor", "largest", "quotient", "remainder"),
    [(10, 2**32 - 1, 2, 4), (10, 2**30 - 1, 1, 2), (7, 2**32 - 1, 4, 6), (16, 2**32 - 1, 1, 1)],
)
def test_operations(divisor: int, largest: int, quotient: int, remainder: int) -> None:
    words = Words()
    quotient_by_constant(words, 5, divisor, largest)
    assert words.count == quotient
    words = Words()
    remainder_by_constant(words, 5, divisor, largest)
    assert words.count == remainder
