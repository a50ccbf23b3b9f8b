"""64-bit division on constants, which the formulas fold: quotient and remainder as Python's."""

from __future__ import annotations

from random import Random

import pytest

from vividc.frontend.narrow.wide import divide as wide_divide
from vividc.frontend.narrow.wide.words import Pair, Words
from vividc.machine.opcodes import Opcode
from vividc.machine.semantics import evaluate
from vividc.ssa.ir import Const, Value

EDGES = (1, 2, 3, 15, 16, 17, 2**30 - 1, 2**30, 2**31, 2**32 - 1, 2**32, 2**32 + 1, 2**44, 2**59)
EDGES += (2**60, 2**60 + 1, 2**63 - 1, 2**63, 2**63 + 1, 2**64 - 2**44, 2**64 - 2, 2**64 - 1)


class Folding(Words):
    """Evaluates every operation."""

    def __init__(self) -> None:
        """There is nothing to emit into."""

    def op(self, opcode: Opcode, *operands: Value | int) -> Value:
        values = [item.word if isinstance(item, Const) else item for item in operands]
        return Const(evaluate(opcode, [value & 0xFFFFFFFF for value in values]))


def pair(value: int) -> Pair:
    return Pair(Const(value & 0xFFFFFFFF), Const(value >> 32))


def whole(value: Pair) -> int:
    return value.low.word | value.high.word << 32


def check(dividend: int, divisor: int) -> None:
    words = Folding()
    expected = divmod(dividend, divisor)
    found = wide_divide.by_variable(words, pair(dividend), pair(divisor))
    assert (whole(found.quotient), whole(found.remainder)) == expected, (dividend, divisor)
    if divisor & (divisor - 1):
        found = wide_divide.by_constant(words, pair(dividend), pair(divisor))
        assert (whole(found.quotient), whole(found.remainder)) == expected, (dividend, divisor)


def test_edges() -> None:
    for dividend in (0, *EDGES):
        for divisor in EDGES:
            check(dividend, divisor)


def random_pairs(seed: int, count: int) -> list[tuple[int, int]]:
    """Multiples of the divisor and their neighbours, and anything else."""
    random = Random(seed)
    found = []
    for _ in range(count):
        divisor = random.getrandbits(random.randint(1, 64)) or 1
        multiple = divisor * random.randrange(2**64 // divisor + 1) + random.randint(-1, 1)
        anything = random.getrandbits(random.randint(1, 64))
        found.append((random.choice([multiple, anything]) % 2**64, divisor))
    return found


def test_random_divisions() -> None:
    for dividend, divisor in random_pairs(1, 1500):
        check(dividend, divisor)


@pytest.mark.slow
def test_many_random_divisions() -> None:
    for dividend, divisor in random_pairs(2, 20_000):
        check(dividend, divisor)
