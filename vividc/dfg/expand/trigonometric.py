"""sin, cos and tan in operations of the array.

An argument that is seen to stay below 2**17 in magnitude (a minimum and a maximum with constants, a
remainder, a sine, a product of such: `argument_magnitudes`) needs 48 operations less.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

from vividc.dfg.expand.builder import EXPONENT_SHIFT, ONE, SIGN, Builder, Expansion
from vividc.dfg.expand.divide import quotient
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

LARGEST_SMALL_ANGLE: Final = 2.0**17
# With u = r**2 on |r| <= pi/4, from the highest power to the constant: (sin(r) / r - 1) / u and
# (cos(r) - 1) / u, whose constant is set to -1/2. Absolute errors 2**-27.8 and 2**-33.1 (least
# squares at 400 Chebyshev points with weight u, the coefficients rounded one after the other from
# the constant on).
SINE: Final = (0xB94C95FA, 0x3C088372, 0xBE2AAAA2)
COSINE: Final = (0x37CCF561, 0xBAB60617, 0x3D2AAAA5, 0xBF000000)


def sine(b: Builder, x: Value) -> Value:
    """sin(x), as sin(|x|) with the sign of x."""
    sin, cos, q, odd = _parts(b, x)
    value = b.op(Opcode.SELECT, odd, cos, sin)
    return b.times_sign(value, b.op(Opcode.XOR, b.op(Opcode.SHL, q, 30), x))


def cosine(b: Builder, x: Value) -> Value:
    """cos(x)."""
    sin, cos, q, odd = _parts(b, x)
    value = b.op(Opcode.SELECT, odd, sin, cos)
    return b.times_sign(value, b.op(Opcode.SHL, b.op(Opcode.ADD, q, 1), 30))


def tangent(b: Builder, x: Value) -> Value:
    """tan(x): sin(r) / cos(r), or -cos(r) / sin(r) in odd quadrants. |sin(r)| is 2**-30 at least
    there.
    """
    sin, cos, q, odd = _parts(b, x)
    value = quotient(b, b.op(Opcode.SELECT, odd, cos, sin), b.op(Opcode.SELECT, odd, sin, cos))
    return b.times_sign(value, b.op(Opcode.XOR, b.op(Opcode.SHL, q, 31), x))


def _parts(b: Builder, x: Value) -> tuple[Value, Value, Value, Value]:
    """sin(r), cos(r), q and whether q is odd."""
    small = b.magnitude < LARGEST_SMALL_ANGLE
    r, q = reduced_angle(b, b.op(Opcode.FABS, x), small=small)
    u = b.op(Opcode.FMUL, r, r)
    sin = b.op(Opcode.FMA, b.op(Opcode.FMUL, u, r), b.horner(SINE, u), r)
    cos = b.op(Opcode.FMA, b.horner(COSINE, u), u, ONE)
    return sin, cos, q, b.op(Opcode.AND, q, 1)


# All words are binary32 bits unless they are of a product.
TWO_OVER_PI: Final = 0x3F22F983


# 1.5 * 2**23: added to a float below 2**22 it leaves the rounded integer in the low bits.
ROUNDING_MAGIC: Final = 0x4B400000


# -pi/2 in three words (Cody and Waite, Software Manual for the Elementary Functions, 1980).
MINUS_HALF_PI: Final = (0xBFC90FDB, 0x333BBD2E, 0x26F72CED)


LARGEST_SMALL: Final = 0x48000000  # 2**17


# 2/pi, 192 bits behind the point, after a word of zeros.
TWO_OVER_PI_BITS: Final = (
    0x00000000,
    0xA2F9836E,
    0x4E441529,
    0xFC2757D1,
    0xF534DDC0,
    0xDB629599,
    0x3C439041,
)


TWO_TO_MINUS_32: Final = 0x2F800000


HALF_PI_2_TO_MINUS_32: Final = 0x3FC90FDB - (32 << EXPONENT_SHIFT)


HALF_QUADRANT: Final = 0x20000000


QUADRANT_SHIFT: Final = 30


def reduced_angle(b: Builder, magnitude: Value, *, small: bool) -> tuple[Value, Value]:
    """(r, q) with magnitude = q pi/2 + r and |r| <= pi/4 (and 0.4 % of it), q modulo 4.

    Below 2**17 by Cody and Waite's three words; from there on by a product of integers, unless
    there is no such magnitude (`small`). Infinities and NaNs give a NaN.
    """
    near, near_quadrant = _small_angle(b, magnitude)
    if small:
        return near, near_quadrant
    far, far_quadrant = _large_angle(b, magnitude)
    is_small = b.op(Opcode.FCMP_OLT, magnitude, LARGEST_SMALL)
    r = b.op(Opcode.SELECT, is_small, near, far)
    return r, b.op(Opcode.SELECT, is_small, near_quadrant, far_quadrant)


def _small_angle(b: Builder, magnitude: Value) -> tuple[Value, Value]:
    """As `reduced_angle` for magnitudes below 2**17, infinite or NaN."""
    shifted = b.op(Opcode.FMA, magnitude, TWO_OVER_PI, ROUNDING_MAGIC)
    n = b.op(Opcode.FSUB, shifted, ROUNDING_MAGIC)
    r = magnitude
    for word in MINUS_HALF_PI:  # the first product and sum are exact
        r = b.op(Opcode.FMA, n, word, r)
    return r, shifted


def _large_angle(b: Builder, magnitude: Value) -> tuple[Value, Value]:
    """As `reduced_angle` for magnitudes from 2 on (Payne and Hanek, "Radian reduction for
    trigonometric functions", 1983): of the product of the mantissa and 2/pi only the 64 bits from
    the quadrant on are computed.
    """
    exponent = b.op(Opcode.LSHR, magnitude, EXPONENT_SHIFT)
    mantissa = b.op(Opcode.OR, b.op(Opcode.SHL, magnitude, 8), SIGN)
    first, second, third = _window(b, magnitude, exponent)
    middle = b.op(Opcode.MUL, mantissa, second)
    low = b.op(Opcode.ADD, middle, b.op(Opcode.MULHU, mantissa, third))
    carry = b.op(Opcode.ICMP_ULT, low, middle)
    high = b.op(Opcode.ADD, b.op(Opcode.MUL, mantissa, first), carry)
    high = b.op(Opcode.ADD, b.op(Opcode.MULHU, mantissa, second), high)
    quadrant = b.op(Opcode.LSHR, b.op(Opcode.ADD, high, HALF_QUADRANT), QUADRANT_SHIFT)
    top = b.op(Opcode.OR, b.op(Opcode.SHL, high, 2), b.op(Opcode.LSHR, low, QUADRANT_SHIFT))
    rest = b.op(Opcode.UITOFP, b.op(Opcode.SHL, low, 2))
    fraction = b.op(Opcode.FMA, rest, TWO_TO_MINUS_32, b.op(Opcode.SITOFP, top))
    nothing = b.op(Opcode.FMUL, magnitude, 0)  # a NaN where the magnitude is not finite
    return b.op(Opcode.FMA, fraction, HALF_PI_2_TO_MINUS_32, nothing), quadrant


def _window(b: Builder, magnitude: Value, exponent: Value) -> list[Value]:
    """96 bits of 2/pi from bit `exponent - 160` on: words chosen by two bits of the exponent, then
    shifted by its low five (a shift counts modulo 32).
    """
    words: list[Value | int] = list(TWO_OVER_PI_BITS)
    for bit, step in ((6, 2), (5, 1)):
        chosen = b.op(Opcode.AND, b.op(Opcode.LSHR, magnitude, EXPONENT_SHIFT + bit), 1)
        pairs = zip(words[step:], words, strict=False)
        words = [b.op(Opcode.SELECT, chosen, later, word) for later, word in pairs]
    power = b.op(Opcode.SHL, 1, exponent)
    return [
        b.op(Opcode.ADD, b.op(Opcode.SHL, high, exponent), b.op(Opcode.MULHU, low, power))
        for high, low in pairwise(words)
    ]


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.SIN: sine,
    Opcode.COS: cosine,
    Opcode.TAN: tangent,
}
