"""Powers in operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT, EXPONENT_SHIFT, ONE, SIGN, Builder, Expansion
from vividc.dfg.expand.divide import divide, reciprocal_estimate
from vividc.dfg.expand.exp import POLYNOMIAL2
from vividc.dfg.expand.log import MINUS_ONE, TWO_TO_MINUS_23, split_positive
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode
from vividc.machine.words import float_of

# All words are binary32 bits.
NAN: Final = 0x7FC00000
# 2 / ln 2 in two words.
SLOPE_HIGH: Final = 0x4038AA3B
SLOPE_LOW: Final = 0x33257060
# (2 atanh(s) / ln 2 - 2 s / ln 2) / s**3 with u = s**2 for |s| <= (sqrt(2) - 1) / (sqrt(2) + 1),
# from the highest power to the constant; relative to the logarithm the error is 2**-36.2 (least
# squares at 400 Chebyshev points with weight u, the coefficients rounded one after the other from
# the constant on).
CUBIC: Final = (0x3EAC8126, 0x3ED2E56C, 0x3F13BB74, 0x3F76384F)
# Beyond 2**31 - 128 every power of another number than 1 has overflown or vanished, as this one
# has; all these exponents are even.
LARGEST_EXPONENT: Final = 0x4EFFFFFF
LARGEST_LOGARITHM: Final = 0x43020000  # 130
SMALLEST_LOGARITHM: Final = 0xC3200000  # -160
ROUNDING_MAGIC: Final = 0x4B400000  # 1.5 * 2**23
MULTIPLIED_OUT: Final = (-2.0, -1.0, 1.0, 2.0, 3.0, 4.0)


def power(b: Builder, x: Value, y: Value) -> Value:
    """x**y = 2**(y log2|x|), the logarithm and the product in two words each; C99's special cases.

    A constant exponent of `MULTIPLIED_OUT` becomes products of x, or of 1 / x, to 2 ulp.
    """
    word = b.word(y)
    if word is not None and float_of(word) in MULTIPLIED_OUT:
        return _product(b, x, int(float_of(word)))
    magnitude = b.op(Opcode.FABS, x)
    finite = b.is_finite_nonzero(magnitude)
    high, low = _binary_logarithm(b, magnitude)
    # -infinity of 0, infinity of infinity
    pole = b.op(Opcode.FSUB, magnitude, b.op(Opcode.SUB, EXPONENT, magnitude))
    high = b.op(Opcode.SELECT, finite, high, pole)
    near = b.op(Opcode.FMAX, y, LARGEST_EXPONENT | SIGN)
    near = b.op(Opcode.FMIN, near, LARGEST_EXPONENT)
    return _specials(b, x, y, near, finite, _two_to_product(b, near, high, low))


def _product(b: Builder, x: Value, exponent: int) -> Value:
    factor = x if exponent > 0 else divide(b, b.constant(ONE), x)
    if abs(exponent) == 1:
        return b.op(Opcode.FMUL, factor, ONE)
    square = b.op(Opcode.FMUL, factor, factor)
    if abs(exponent) == 2:  # noqa: PLR2004
        return square
    return b.op(Opcode.FMUL, square, factor if abs(exponent) == 3 else square)  # noqa: PLR2004


def _binary_logarithm(b: Builder, x: Value) -> tuple[Value, Value]:
    """log2(x) as a sum of two words, to 2**-32 of it: with x = 2**k m and s = (m - 1) / (m + 1) it
    is k + 2 atanh(s) / ln 2.
    """
    k, m = split_positive(b, x)
    s, s_low = _ratio(b, m)
    u = b.op(Opcode.FMUL, s, s)
    minus_head = b.op(Opcode.FMUL, s, SLOPE_HIGH | SIGN)
    tail = b.op(Opcode.FMA, s, SLOPE_HIGH, minus_head)  # the product's rounding error
    tail = b.op(Opcode.FMA, s, SLOPE_LOW, tail)
    slope = b.op(Opcode.FMA, u, SLOPE_HIGH, SLOPE_HIGH)  # of atanh at s
    tail = b.op(Opcode.FMA, s_low, slope, tail)
    tail = b.op(Opcode.FMA, b.op(Opcode.FMUL, s, u), b.horner(CUBIC, u), tail)
    k = b.op(Opcode.FMUL, k, TWO_TO_MINUS_23)
    # Two sums with their rounding errors (Dekker, "A floating-point technique", 1971): the first
    # operand is 0 or the larger one.
    head = b.op(Opcode.FSUB, k, minus_head)
    error = b.op(Opcode.FSUB, b.op(Opcode.FSUB, k, head), minus_head)
    tail = b.op(Opcode.FADD, error, tail)
    high = b.op(Opcode.FADD, head, tail)
    return high, b.op(Opcode.FADD, b.op(Opcode.FSUB, head, high), tail)


def _ratio(b: Builder, m: Value) -> tuple[Value, Value]:
    """(m - 1) / (m + 1), and what it is rounded by."""
    numerator = b.op(Opcode.FADD, m, MINUS_ONE)
    d = b.op(Opcode.FADD, m, ONE)
    minus_d_low = b.op(Opcode.FSUB, b.op(Opcode.FADD, d, MINUS_ONE), m)
    inverse = reciprocal_estimate(b, d)
    s = b.op(Opcode.FMUL, numerator, inverse)
    rest = b.op(Opcode.FNMA, d, s, numerator)
    rest = b.op(Opcode.FMA, minus_d_low, s, rest)
    rest = b.op(Opcode.FMUL, rest, inverse)
    near = b.op(Opcode.FADD, s, rest)
    return near, b.op(Opcode.FADD, b.op(Opcode.FSUB, s, near), rest)


def _two_to_product(b: Builder, y: Value, high: Value, low: Value) -> Value:
    """2**(y (high + low)), rounded once more where it is subnormal."""
    product = b.op(Opcode.FMUL, y, high)
    rest = b.op(Opcode.FMS, y, high, product)
    rest = b.op(Opcode.FMA, y, low, rest)
    near = b.op(Opcode.FMIN, product, LARGEST_LOGARITHM)
    near = b.op(Opcode.FMAX, near, SMALLEST_LOGARITHM)
    in_range = b.op(Opcode.FCMP_OEQ, near, product)
    shifted = b.op(Opcode.FADD, near, ROUNDING_MAGIC)
    r = b.op(Opcode.FSUB, near, b.op(Opcode.FSUB, shifted, ROUNDING_MAGIC))
    r = b.op(Opcode.FADD, rest, r, pred=in_range)
    double = b.horner(POLYNOMIAL2, r)
    exponent = b.op(Opcode.SUB, shifted, ROUNDING_MAGIC + 1)
    half = b.op(Opcode.ASHR, exponent, 1)
    other = b.op(Opcode.SHL, b.op(Opcode.SUB, exponent, half), EXPONENT_SHIFT)
    scaled = b.op(Opcode.ADD, double, b.op(Opcode.SHL, half, EXPONENT_SHIFT))
    return b.op(Opcode.FMUL, scaled, b.op(Opcode.ADD, other, ONE))


def _specials(b: Builder, x: Value, y: Value, near: Value, finite: Value, value: Value) -> Value:
    """The sign of an odd power of a negative x; NaN of another than a whole power of it; 1 of 1 and
    to the 0th.
    """
    whole = b.op(Opcode.FPTOSI, near)
    fraction = b.op(Opcode.FCMP_UNE, b.op(Opcode.SITOFP, whole), near)
    odd = b.op(Opcode.SELECT, fraction, 0, b.op(Opcode.SHL, whole, 31))
    value = b.op(Opcode.XOR, value, b.op(Opcode.AND, odd, x))
    negative = b.op(Opcode.AND, b.op(Opcode.FCMP_OLT, x, 0), finite)
    undefined = b.op(Opcode.AND, negative, fraction)
    undefined = b.op(Opcode.OR, undefined, b.op(Opcode.FCMP_UNO, x, y))
    value = b.op(Opcode.SELECT, undefined, NAN, value)
    one = b.op(Opcode.OR, b.op(Opcode.FCMP_OEQ, x, ONE), b.op(Opcode.FCMP_OEQ, y, 0))
    return b.op(Opcode.SELECT, one, ONE, value)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.POW: power,
}
