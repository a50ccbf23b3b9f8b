"""Integer division in word operations, wherever it is needed: by a constant, by a known reciprocal.

The functions write operations through an `Emit`, so that the frontend, which knows ranges, and the
expansion of a graph share them. All words are unsigned here.

Sources: Granlund and Montgomery, "Division by invariant integers using multiplication" (1994);
Robison, "N-bit unsigned division via N-bit multiply-add" (2005), for the multipliers rounded down;
Lemire, Kaser and Kurz, "Faster remainder by direct computation" (2019).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK

V = TypeVar("V")


class Emit(Protocol[V]):
    """Writes one operation and gives its result; an int operand is the word of a constant."""

    def __call__(self, opcode: Opcode, *operands: V | int) -> V:
        """The operation `opcode` on `operands`."""


@dataclass(frozen=True, slots=True)
class Multiplier:
    """How to divide: `((n >> before) + increment) * factor >> 32 >> after`."""

    factor: int
    after: int
    before: int = 0
    increment: bool = False


def multiplier(divisor: int, largest: int) -> Multiplier:
    """The cheapest multiplier that is exact for every dividend up to `largest`.

    With factor = ceil(2**p / divisor) and e = factor * divisor - 2**p, the product is above the
    quotient by less than its distance to the next one if largest * e < 2**p. Where the factor
    would need 33 bits, an even dividend loses a bit first; an odd one is incremented and multiplied
    by floor(2**p / divisor) instead, which is exact if (largest + 1) * (2**p mod divisor) <= 2**p.

    Parameters
    ----------
    divisor
        3 .. 2**32-1, no power of two.
    largest
        Largest dividend, up to 2**32-1.
    """
    up = _rounded_up(divisor, largest)
    if up is not None:
        return up
    before = (divisor & -divisor).bit_length() - 1
    odd = _rounded_up(divisor >> before, largest >> before) if before else None
    if odd is not None:
        return Multiplier(odd.factor, odd.after, before)
    after = divisor.bit_length() - 1
    return Multiplier((1 << WORD_BITS + after) // divisor, after, increment=True)


def _rounded_up(divisor: int, largest: int) -> Multiplier | None:
    for after in range(divisor.bit_length()):
        power = 1 << WORD_BITS + after
        factor = -(-power // divisor)
        if factor <= WORD_MASK and largest * (factor * divisor - power) < power:
            return Multiplier(factor, after)
    return None


def quotient_by_constant(emit: Emit[V], dividend: V, divisor: int, largest: int) -> V | int:
    """dividend / divisor in at most four operations.

    Parameters
    ----------
    divisor
        1 .. 2**32-1.
    largest
        Largest dividend, up to 2**32-1.
    """
    if divisor > largest:
        return 0
    if divisor & (divisor - 1) == 0:
        return _shifted(emit, dividend, divisor.bit_length() - 1)
    by = multiplier(divisor, largest)
    value = _shifted(emit, dividend, by.before)
    if by.increment:
        value = _incremented(emit, value, largest)
    return _shifted(emit, emit(Opcode.MULHU, value, by.factor), by.after)


def remainder_by_constant(emit: Emit[V], dividend: V, divisor: int, largest: int) -> V | int:
    """dividend % divisor: two operations where the fraction of one product tells it.

    With factor = ceil(2**32 / divisor) and e = factor * divisor - 2**32, the low word of
    dividend * factor times the divisor has the remainder as its high word if largest * e < 2**32.
    """
    if divisor > largest:
        return dividend
    if divisor & (divisor - 1) == 0:
        return emit(Opcode.AND, dividend, divisor - 1)
    factor = -(-(1 << WORD_BITS) // divisor)
    if largest * (factor * divisor - (1 << WORD_BITS)) < 1 << WORD_BITS:
        return emit(Opcode.MULHU, emit(Opcode.MUL, dividend, factor), divisor)
    quotient = quotient_by_constant(emit, dividend, divisor, largest)
    return remainder_of(emit, dividend, quotient, divisor)


def remainder_of(emit: Emit[V], dividend: V | int, quotient: V | int, divisor: V | int) -> V:
    """What a quotient leaves."""
    if isinstance(divisor, int):
        multiple = emit(Opcode.MUL, quotient, -divisor & WORD_MASK)
        return emit(Opcode.ADD, dividend, multiple)
    return emit(Opcode.SUB, dividend, emit(Opcode.MUL, quotient, divisor))


def _shifted(emit: Emit[V], value: V, amount: int) -> V:
    return emit(Opcode.LSHR, value, amount) if amount else value


def _incremented(emit: Emit[V], value: V, largest: int) -> V:
    """value + 1, or 2**32-1 if that wraps: the quotient is then the same, since the divisors of
    2**32-1 have multipliers of 32 bits.
    """
    if largest < WORD_MASK:
        return emit(Opcode.ADD, value, 1)
    return emit(Opcode.ADD, value, emit(Opcode.ICMP_NE, value, WORD_MASK))
