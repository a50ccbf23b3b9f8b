"""Division in operations of the array, correctly rounded."""

from __future__ import annotations

import math
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
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode
from vividc.machine.words import float_of, word_of

# Subtracting a number's bits negates its exponent and makes a chord of 1/m of its mantissa; this
# constant balances the chord's error to +-5.06 % on all of [1, 2).
RECIPROCAL_MAGIC: Final = 0x7EF311C7
NEWTON_STEPS: Final = 2  # 5.06e-2, 2.6e-3, 6.6e-6
SUBNORMAL_BITS: Final = 24
SUBNORMAL_SCALE: Final = 0x4B800000  # 2**24, which makes any subnormal normal
# Exponents beyond +-200 overflow or vanish all the same, and half of these is an exponent
# of a normal number.
EXPONENT_LIMIT: Final = 200
SMALLEST_INVERTIBLE: Final = 2.0**-127
LARGEST_CONSTANT: Final = 2.0**24
UP: Final = 0x5F800000  # 2**64
DOWN: Final = 0x1F800000  # 2**-64
_MINUS_LIMIT: Final = -EXPONENT_LIMIT & 0xFFFFFFFF


def divide(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor in 47 operations, fewer for most constant divisors
    (`quotient_by_constant`).

    The mantissas are divided: an estimate of the reciprocal by an integer subtraction, Newton steps
    in FMAs, and two corrections by exact residuals (Markstein, "Computation of elementary functions
    on the IBM RISC System/6000 processor", 1990). The exponent comes by two multiplications, of
    which only the last can round, overflow or underflow.

    Correctly rounded (IEEE 754 round to nearest even) wherever the result is normal, infinite, zero
    or NaN; a subnormal result is rounded twice and has an error of at most 0.75 ulp. Nothing is
    flushed: subnormal operands count. The proof is by
    cases, in the test: a quotient is at least 1/(2d) ulp from the middle of two numbers, d being
    the divisor's mantissa as an integer; for all but two of the 2**23 mantissas the error of the
    reciprocal is too small to cross that, and the hardest dividend of those two is tried.
    """
    word = b.word(divisor)
    by_constant = None if word is None else quotient_by_constant(b, dividend, word)
    if by_constant is not None:
        return by_constant
    a, exponent_a, small_a, finite_a = _unpack(b, dividend)
    d, exponent_d, small_d, finite_d = _unpack(b, divisor)
    quotient = _mantissas(b, a, d)
    # The fields differ by less than 2**31.
    exponent = b.op(Opcode.ASHR, b.op(Opcode.SUB, exponent_a, exponent_d), EXPONENT_SHIFT)
    exponent = b.op(Opcode.ADD, -SUBNORMAL_BITS & 0xFFFFFFFF, exponent, pred=small_a)
    exponent = b.op(Opcode.ADD, SUBNORMAL_BITS, exponent, pred=small_d)
    scaled = _scale(b, quotient, exponent)
    # infinity - bits turns 0 into infinity, infinity into 0, NaN into NaN and any other number into
    # a finite one, all of the same sign: the product has what the quotient of specials is.
    special = b.op(Opcode.FMUL, dividend, b.op(Opcode.SUB, EXPONENT, divisor))
    value = b.op(Opcode.SELECT, finite_a, scaled, special)
    return b.op(Opcode.SELECT, finite_d, value, special)


def quotient_by_constant(b: Builder, dividend: Value, word: int) -> Value | None:
    """dividend / constant, rounded as by `divide`, in 1 operation if the constant is a power of two
    whose inverse is a number, and in 13 to 16 if it is another from 2**-24 to 2**24 in magnitude.

    A quotient by the constant's inverse and two corrections by exact residuals. Small dividends
    are scaled up, so that the residuals are normal, and large ones down where the constant is below
    1.
    """
    constant = float_of(word)
    if math.frexp(constant)[0] in (0.5, -0.5) and abs(constant) >= SMALLEST_INVERTIBLE:
        return b.op(Opcode.FMUL, dividend, word_of(1.0 / constant))
    if not 1 / LARGEST_CONSTANT <= abs(constant) <= LARGEST_CONSTANT:
        return None
    inverse = word_of(1.0 / constant)
    magnitude = b.op(Opcode.FABS, dividend)
    scales = [(b.op(Opcode.FCMP_OLT, magnitude, DOWN), UP, DOWN)]
    if abs(constant) < 1:
        scales.append((b.op(Opcode.FCMP_OLE, UP, magnitude), DOWN, UP))
    near = dividend
    for beyond, factor, _ in scales:
        near = b.op(Opcode.FMUL, factor, near, pred=beyond)
    value = b.op(Opcode.FMUL, near, inverse)
    for _ in range(2):
        rest = b.op(Opcode.FMA, value, word ^ SIGN, near)
        value = b.op(Opcode.FMA, rest, inverse, value)
    for beyond, _, factor in scales:
        value = b.op(Opcode.FMUL, factor, value, pred=beyond)
    special = b.op(Opcode.FMUL, dividend, inverse)
    return b.op(Opcode.SELECT, b.is_finite_nonzero(magnitude), value, special)


def quotient(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor in 9 operations, to 0.501 ulp, where the divisor and its reciprocal are
    normal and no intermediate product overflows or underflows. The sequence is that of `divide`
    with one correction less.
    """
    minus_d = b.op(Opcode.FNEG, divisor)
    y = reciprocal_estimate(b, divisor, minus_d)
    near = b.op(Opcode.FMUL, dividend, y)
    return b.op(Opcode.FMA, b.op(Opcode.FMA, minus_d, near, dividend), y, near)


def reciprocal_estimate(b: Builder, divisor: Value, minus_d: Value) -> Value:
    """1 / divisor to 6.6e-6, of the divisor and its negative."""
    y = b.op(Opcode.SUB, RECIPROCAL_MAGIC, divisor)
    for _ in range(NEWTON_STEPS):
        y = b.op(Opcode.FMA, y, b.op(Opcode.FMA, minus_d, y, ONE), y)
    return y


def _unpack(b: Builder, x: Value) -> tuple[Value, Value, Value, Value]:
    """Signed mantissa in [1, 2), exponent field, and whether x was subnormal, and finite not 0."""
    magnitude = b.op(Opcode.FABS, x)
    small = b.op(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
    normal = b.op(Opcode.FMUL, SUBNORMAL_SCALE, x, pred=small)
    exponent = b.op(Opcode.AND, normal, EXPONENT)
    mantissa = b.op(Opcode.ADD, b.op(Opcode.SUB, normal, exponent), ONE)
    return mantissa, exponent, small, b.is_finite_nonzero(magnitude)


def _mantissas(b: Builder, a: Value, d: Value) -> Value:
    """a / d for magnitudes in [1, 2), correctly rounded."""
    minus_d = b.op(Opcode.FNEG, d)
    y = reciprocal_estimate(b, d, minus_d)
    # The last step is cubic, or y would be low by 4e-11, too much where 1/d is half-way between two
    # numbers.
    error = b.op(Opcode.FMA, minus_d, y, ONE)
    y = b.op(Opcode.FMA, y, b.op(Opcode.FMA, error, error, error), y)
    quotient = b.op(Opcode.FMUL, a, y)
    for _ in range(2):  # to within half an ulp and a little, then to the nearest
        quotient = b.op(Opcode.FMA, b.op(Opcode.FMA, minus_d, quotient, a), y, quotient)
    return quotient


def _scale(b: Builder, x: Value, exponent: Value) -> Value:
    """x * 2**exponent for 1/2 < |x| < 2, rounded once."""
    exponent = b.op(Opcode.SMIN, b.op(Opcode.SMAX, exponent, _MINUS_LIMIT), EXPONENT_LIMIT)
    half = b.op(Opcode.ASHR, exponent, 1)
    rest = b.op(Opcode.SUB, exponent, half)
    near = b.op(Opcode.ADD, x, b.op(Opcode.SHL, half, EXPONENT_SHIFT))
    scale = b.op(Opcode.ADD, b.op(Opcode.SHL, rest, EXPONENT_SHIFT), ONE)
    return b.op(Opcode.FMUL, near, scale)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.FDIV: divide,
}
