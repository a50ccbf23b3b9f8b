"""Angles modulo pi/2 in operations of the array, for every float."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

from vividc.dfg.passes.expand_builder import EXPONENT_SHIFT, SIGN, Builder
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

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
