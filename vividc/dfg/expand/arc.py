"""Inverse trigonometric functions in operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT, EXPONENT_SHIFT, ONE, SIGN, Builder, Expansion
from vividc.dfg.expand.divide import quotient
from vividc.dfg.expand.roots import root_of_normal
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

# All words are binary32 bits.
HALF_PI_HIGH: Final = 0x3FC90FDB
HALF_PI_LOW: Final = 0xB33BBD2E
HALF: Final = 0x3F000000
MINUS_HALF: Final = 0xBF000000
MINUS_ONE: Final = 0xBF800000
MINUS_THREE: Final = 0xC0400000
TWO: Final = 0x40000000
NAN: Final = 0x7FC00000
LARGE: Final = 0x5D800000  # 2**60, where atan has long rounded to pi/2
FACTOR_EXPONENT: Final = (127 + 127 + 32) << EXPONENT_SHIFT
SMALLEST_EXPONENT: Final = 32 << EXPONENT_SHIFT
# (atan(t) / t - 1) / u with u = t**2 on [0, 1], from the highest power to the constant; relative to
# atan the error is 2**-28.2. This and the next: least squares at 400 Chebyshev points, weights
# u t / atan(t) here, u there, the coefficients rounded one after the other from the constant on.
ARCTANGENT: Final = (
    0xBAE3EE42,
    0x3C2EC38D,
    0xBCFB9173,
    0x3D6B6F0A,
    0xBDAB84DD,
    0x3DE018BF,
    0xBE120BBD,
    0x3E4CC880,
    0xBEAAAA9D,
)
# (asin(t) / t - 1) / u with u = t**2 on [0, 1/4]: 2**-27.5.
ARCSINE: Final = (0x3D2CB296, 0x3CC6129C, 0x3D3A4046, 0x3D9980D6, 0x3E2AAAE5)


def arctangent(b: Builder, x: Value) -> Value:
    """atan(x), which for |x| > 1 is pi/2 - atan(1/|x|) with the sign of x."""
    magnitude = b.op(Opcode.FABS, x)
    steep = b.op(Opcode.FCMP_OLT, ONE, magnitude)
    inverse = quotient(b, b.constant(ONE), b.op(Opcode.FMIN, magnitude, LARGE))
    value = _odd(b, b.op(Opcode.SELECT, steep, inverse, magnitude), ARCTANGENT)
    return b.times_sign(_from_right_angle(b, value, steep), x)


def arctangent2(b: Builder, y: Value, x: Value) -> Value:
    """atan2(y, x): the arc tangent of the smaller magnitude over the larger, in [0, pi/4], and the
    octant. Zeros and infinities are C99's.
    """
    rise, run = b.op(Opcode.FABS, y), b.op(Opcode.FABS, x)
    steep = b.op(Opcode.FCMP_OLT, run, rise)
    value = _odd(b, _slope(b, rise, run, steep), ARCTANGENT)
    left = b.op(Opcode.LSHR, x, 31)
    # right angles from the positive x axis, to or from which the arc counts
    base = b.op(Opcode.SELECT, left, TWO, 0)
    base = b.op(Opcode.SELECT, steep, ONE, base)
    back = b.op(Opcode.SHL, b.op(Opcode.XOR, steep, left), 31)
    value = b.op(Opcode.FMA, base, HALF_PI_LOW, b.op(Opcode.XOR, value, back))
    value = b.op(Opcode.FMA, base, HALF_PI_HIGH, value)
    value = b.times_sign(value, y)
    return b.op(Opcode.SELECT, b.op(Opcode.FCMP_ORD, x, y), value, NAN)


def arcsine(b: Builder, x: Value) -> Value:
    """asin(x), which for |x| > 1/2 is pi/2 - 2 asin(sqrt((1 - |x|) / 2)) with the sign of x."""
    value, steep, outside = _half_arcsine(b, x)
    double = b.op(Opcode.FMA, MINUS_THREE, value, value, pred=steep)
    value = b.op(Opcode.FADD, HALF_PI_LOW, double, pred=steep)
    value = b.op(Opcode.FADD, HALF_PI_HIGH, value, pred=steep)
    return b.op(Opcode.SELECT, outside, NAN, b.times_sign(value, x))


def arccosine(b: Builder, x: Value) -> Value:
    """acos(x): pi/2 - asin(x), beyond 1/2 in magnitude 2 asin(sqrt((1 - |x|) / 2)), from pi back
    where x is negative.
    """
    value, steep, outside = _half_arcsine(b, x)
    factor = b.op(Opcode.SELECT, steep, TWO, MINUS_ONE)
    factor = b.op(Opcode.XOR, factor, b.op(Opcode.AND, x, SIGN))
    left = b.op(Opcode.SELECT, b.op(Opcode.LSHR, x, 31), TWO, 0)
    base = b.op(Opcode.SELECT, steep, left, ONE)
    low = b.op(Opcode.FMUL, base, HALF_PI_LOW)
    value = b.op(Opcode.FMA, base, HALF_PI_HIGH, b.op(Opcode.FMA, value, factor, low))
    return b.op(Opcode.SELECT, outside, NAN, value)


def _slope(b: Builder, rise: Value, run: Value, steep: Value) -> Value:
    """The smaller of two magnitudes over the larger; 0 if both are 0, 1 if both are infinite."""
    small = b.op(Opcode.SELECT, steep, run, rise)
    large = b.op(Opcode.SELECT, steep, rise, run)
    # A factor that makes the larger 2**32 or, where that is no number, at least 2**-22: the
    # residual of a normal slope is then normal, and no bit of the smaller is lost before.
    exponent = b.op(Opcode.SMAX, b.op(Opcode.AND, large, EXPONENT), SMALLEST_EXPONENT)
    factor = b.op(Opcode.SUB, FACTOR_EXPONENT, exponent)
    slope = quotient(b, b.op(Opcode.FMUL, small, factor), b.op(Opcode.FMUL, large, factor))
    both = b.op(Opcode.FCMP_OEQ, small, EXPONENT)
    special = b.op(Opcode.SELECT, both, ONE, 0)
    return b.op(Opcode.SELECT, b.is_finite_nonzero(large), slope, special)


def _from_right_angle(b: Builder, value: Value, steep: Value) -> Value:
    """pi/2 - value where steep, else value."""
    value = b.op(Opcode.FSUB, HALF_PI_LOW, value, pred=steep)
    return b.op(Opcode.FADD, HALF_PI_HIGH, value, pred=steep)


def _half_arcsine(b: Builder, x: Value) -> tuple[Value, Value, Value]:
    """asin(|x|), or where |x| > 1/2 (the second) asin(sqrt((1 - |x|) / 2)); whether |x| > 1."""
    magnitude = b.op(Opcode.FABS, x)
    steep = b.op(Opcode.FCMP_OLT, HALF, magnitude)
    rest = b.op(Opcode.FMA, magnitude, MINUS_HALF, HALF)
    root = root_of_normal(b, rest)
    u = b.op(Opcode.SELECT, steep, rest, b.op(Opcode.FMUL, x, x))
    t = b.op(Opcode.SELECT, steep, root, magnitude)
    value = b.op(Opcode.FMA, b.op(Opcode.FMUL, t, u), b.horner(ARCSINE, u), t)
    return value, steep, b.op(Opcode.FCMP_OLT, ONE, magnitude)


def _odd(b: Builder, t: Value, coefficients: tuple[int, ...]) -> Value:
    """t + t**3 P(t**2)."""
    u = b.op(Opcode.FMUL, t, t)
    return b.op(Opcode.FMA, b.op(Opcode.FMUL, u, t), b.horner(coefficients, u), t)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.ASIN: arcsine,
    Opcode.ACOS: arccosine,
    Opcode.ATAN: arctangent,
    Opcode.ATAN2: arctangent2,
}
