"""C's fmod in operations of the array: exact for all operands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from vividc.dfg.expand.builder import (
    EXPONENT,
    EXPONENT_SHIFT,
    ONE,
    SIGN,
    SMALLEST_NORMAL,
    Builder,
    Expansion,
)
from vividc.dfg.expand.divide import reciprocal_estimate
from vividc.dfg.expand.rounding import truncate
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode
from vividc.machine.words import INT_MAX, WORD_MASK

NAN: Final = 0x7FC00000
FRACTION: Final = 0x007FFFFF
SUBNORMAL_BITS: Final = 24
SUBNORMAL_SCALE: Final = 0x4B800000  # 2**24
TWO_TO_30: Final = 0x4E800000
TWO_TO_32: Final = 0x4F800000
STEP: Final = 31  # bits of the quotient in a step
STEP_INVERSE: Final = (1 << 32) // STEP + 1  # the high product by it divides small numbers by 31
LARGEST_FIELD: Final = 254
SMALLEST_FIELD: Final = -22  # of 2**-149
INTEGER_EXPONENT: Final = 150  # field of 2**23, the unit of mantissas being 1
LARGEST_POWER: Final = 0x7E800000  # 2**126


def remainder(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend - n divisor with the sign of the dividend, n being the quotient truncated.

    The mantissas are integers; 31 bits of the quotient at a time are the high word of a product
    with the inverse, at most 1 too small (Barrett, "Implementing the RSA public key encryption
    algorithm on a standard digital signal processor", 1986). As many steps are made as the
    exponents can differ by; fewer if the divisor is a constant, and none if that is a power of two
    from 1 on.
    """
    word = b.word(divisor)
    if word is not None and ONE <= word & INT_MAX <= LARGEST_POWER and not word & FRACTION:
        return _of_power_of_two(b, dividend, word & INT_MAX)
    return _general(b, dividend, divisor, _steps(word))


def _of_power_of_two(b: Builder, dividend: Value, divisor: int) -> Value:
    """Quotient, its integer part and the remainder are exact; an infinity gives NaN."""
    magnitude = b.op(Opcode.FABS, dividend)
    inverse = (LARGEST_FIELD << EXPONENT_SHIFT) - divisor
    whole = truncate(b, b.op(Opcode.FMUL, magnitude, inverse))
    rest = b.op(Opcode.FMA, whole, divisor | SIGN, magnitude)
    return b.times_sign(rest, dividend)


def _steps(divisor: int | None) -> int:
    """Whole steps that the largest dividend needs, after the first."""
    field = SMALLEST_FIELD
    if divisor is not None and divisor & EXPONENT:
        field = (divisor & EXPONENT) >> EXPONENT_SHIFT
    return (LARGEST_FIELD - field) // STEP


@dataclass(frozen=True, slots=True)
class _Modulus:
    """The divisor's mantissa m as an integer in [2**23, 2**24), -m, and 2**55 / m rounded to the
    integer below (of an integer to the one before).
    """

    m: Value
    minus_m: Value
    inverse: Value


def _general(b: Builder, dividend: Value, divisor: Value, steps: int) -> Value:
    a, d = b.op(Opcode.FABS, dividend), b.op(Opcode.FABS, divisor)
    field_a, rest = _unpack(b, a)
    field_d, mantissa = _unpack(b, d)
    modulus = _modulus(b, mantissa)
    difference = b.op(Opcode.SUB, field_a, field_d)
    count = b.op(Opcode.MULHU, difference, STEP_INVERSE)
    first = b.op(Opcode.SUB, difference, b.op(Opcode.MUL, count, STEP))
    rest = _corrected(b, rest, modulus)
    rest = _step(b, rest, first, modulus)
    for index in range(steps):
        longer = b.op(Opcode.ICMP_SLT, index, count)
        rest = b.op(Opcode.SELECT, longer, _step(b, rest, None, modulus), rest)
    value = _pack(b, rest, field_d)
    value = b.op(Opcode.SELECT, b.op(Opcode.ICMP_ULT, a, d), a, value)
    value = b.op(Opcode.OR, value, b.op(Opcode.AND, dividend, SIGN))
    # The dividend is finite, the divisor neither 0 nor a NaN.
    defined = b.op(Opcode.ICMP_ULT, b.op(Opcode.SUB, d, 1), EXPONENT)
    defined = b.op(Opcode.AND, defined, b.op(Opcode.ICMP_ULT, a, EXPONENT))
    return b.op(Opcode.SELECT, defined, value, NAN)


def _unpack(b: Builder, magnitude: Value) -> tuple[Value, Value]:
    """Exponent field, below 1 for subnormals, and mantissa as an integer from 2**23 on."""
    small = b.op(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
    normal = b.op(Opcode.FMUL, SUBNORMAL_SCALE, magnitude, pred=small)
    field = b.op(Opcode.LSHR, normal, EXPONENT_SHIFT)
    field = b.op(Opcode.ADD, -SUBNORMAL_BITS & WORD_MASK, field, pred=small)
    mantissa = b.op(Opcode.OR, b.op(Opcode.AND, normal, FRACTION), SMALLEST_NORMAL)
    return field, mantissa


def _modulus(b: Builder, m: Value) -> _Modulus:
    """The inverse from a reciprocal in two words, 1 to 3 too small, then exactly."""
    d = b.op(Opcode.ADD, m, ONE - SMALLEST_NORMAL)  # m / 2**23
    y = reciprocal_estimate(b, d)
    y = b.op(Opcode.FMA, b.op(Opcode.FNMA, d, y, ONE), y, y)
    y_low = b.op(Opcode.FMUL, b.op(Opcode.FNMA, d, y, ONE), y)
    high = b.op(Opcode.SHL, b.op(Opcode.FPTOSI, b.op(Opcode.FMUL, y, TWO_TO_30)), 2)
    low = b.op(Opcode.FPTOSI, b.op(Opcode.FMUL, y_low, TWO_TO_32))
    inverse = b.op(Opcode.ADD, b.op(Opcode.ADD, high, low), -2 & WORD_MASK)
    minus_m = b.op(Opcode.SUB, 0, m)
    rest = b.op(Opcode.MUL, inverse, minus_m)  # 2**55 - inverse m
    twice = b.op(Opcode.ICMP_SLT, b.op(Opcode.SHL, m, 1), rest)
    inverse = b.op(Opcode.ADD, 2, inverse, pred=twice)
    rest = b.op(Opcode.ADD, b.op(Opcode.SHL, minus_m, 1), rest, pred=twice)
    once = b.op(Opcode.ICMP_SLT, m, rest)
    return _Modulus(m, minus_m, b.op(Opcode.ADD, 1, inverse, pred=once))


def _step(b: Builder, rest: Value, bits: Value | None, modulus: _Modulus) -> Value:
    """rest * 2**bits modulo m; without `bits` they are 31."""
    quotient = b.op(Opcode.MULHU, b.op(Opcode.SHL, rest, 8), modulus.inverse)
    if bits is not None:
        quotient = b.op(Opcode.LSHR, quotient, b.op(Opcode.SUB, STEP, bits))
    shifted = b.op(Opcode.SHL, rest, STEP if bits is None else bits)
    low = b.op(Opcode.ADD, b.op(Opcode.MUL, quotient, modulus.minus_m), shifted)
    return _corrected(b, low, modulus)


def _corrected(b: Builder, rest: Value, modulus: _Modulus) -> Value:
    """`rest` or `rest` - m, of an integer below 2 m."""
    less = b.op(Opcode.ADD, rest, modulus.minus_m)
    return b.op(Opcode.ADD, modulus.m, less, pred=b.op(Opcode.ICMP_SLT, less, 0))


def _pack(b: Builder, mantissa: Value, field: Value) -> Value:
    """mantissa * 2**(field - 150), which is exact, in two factors."""
    exponent = b.op(Opcode.SUB, field, INTEGER_EXPONENT)
    half = b.op(Opcode.ASHR, exponent, 1)
    value = b.op(Opcode.SITOFP, mantissa)
    for part in (b.op(Opcode.SUB, exponent, half), half):
        scale = b.op(Opcode.ADD, b.op(Opcode.SHL, part, EXPONENT_SHIFT), ONE)
        value = b.op(Opcode.FMUL, value, scale)
    return value


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.FREM: remainder,
}
