"""exp and exp2 in operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT_SHIFT, Builder
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

# All words are binary32 bits.
LOG2_E: Final = 0x3FB8AA3B
# 1.5 * 2**23 + 126: added to a float below 2**22 it leaves the rounded integer, 126 higher, in the
# low bits.
ROUNDING_MAGIC: Final = 0x4B40007E
# The magic number + 129: past the largest exponent, so that its scale is infinity.
ROUNDED_LIMIT: Final = 0x4B4000FF
# -ln 2 in two words (Cody and Waite, Software Manual for the Elementary Functions, 1980).
MINUS_LN2_HIGH: Final = 0xBF317218
MINUS_LN2_LOW: Final = 0x3102E308
# 2 exp(r) on |r| <= ln(2) / 2, relative error 2**-28.2, from the highest power to the constant.
POLYNOMIAL: Final = (
    0x3B35265A,
    0x3C891CC3,
    0x3DAAAC58,
    0x3EAAAA49,
    0x3F7FFFFE,
    0x40000000,
    0x40000000,
)
SMALLEST_ARGUMENT: Final = 0xC2AE0000  # -87.0
# 2 * 2**r on |r| <= 1/2, relative error 2**-28.0 (weighted least squares at 400 Chebyshev points,
# the coefficients rounded one after the other from the constant on).
POLYNOMIAL2: Final = (
    0x399FC836,
    0x3B2F8533,
    0x3C9D9858,
    0x3DE357BC,
    0x3EF5FDEC,
    0x3FB17218,
    0x40000000,
)
SMALLEST_POWER: Final = 0xC2FB0000  # -125.5


def exponential(b: Builder, x: Value) -> Value:
    """exp(x) in 14 operations.

    With n = round(x / ln 2) and r = x - n ln 2, exp(x) = 2**(n-1) * 2 exp(r). The rounding is the
    addition of a large number, whose low bits are then the biased exponent of the scale; 2 exp(r)
    is a polynomial of degree 6 in Horner form (minimax, the coefficients rounded one after the
    other).

    Over all 2**32 inputs the error is at most 0.892 ulp wherever the result is 2**-125.5 (1.66e-38)
    or more. Smaller results (x < -86.99) are 0; overflow (x > 88.72) gives infinity; NaN gives the
    canonical NaN; exp(+-0) is 1.
    """
    shifted = _rounded(b, b.op(Opcode.FMA, x, LOG2_E, ROUNDING_MAGIC))
    n = b.op(Opcode.FSUB, shifted, ROUNDING_MAGIC)
    r = b.op(Opcode.FMA, n, MINUS_LN2_HIGH, x)
    r = b.op(Opcode.FMA, n, MINUS_LN2_LOW, r)
    in_range = b.op(Opcode.FCMP_ULE, SMALLEST_ARGUMENT, x)
    return _scaled(b, b.horner(POLYNOMIAL, r), shifted, in_range)


def power_of_two(b: Builder, x: Value) -> Value:
    """2**x in 13 operations, as `exponential` but with r = x - n, which is exact.

    The error is at most 0.79 ulp (0.7815 found at every 37th argument) wherever the result is above
    2**-125.5 (1.66e-38). Smaller results are 0; overflow (x >= 128) gives infinity; NaN gives the
    canonical NaN; integers are exact.
    """
    shifted = _rounded(b, b.op(Opcode.FADD, x, ROUNDING_MAGIC))
    r = b.op(Opcode.FSUB, x, b.op(Opcode.FSUB, shifted, ROUNDING_MAGIC))
    in_range = b.op(Opcode.FCMP_ULE, SMALLEST_POWER, x)
    return _scaled(b, b.horner(POLYNOMIAL2, r), shifted, in_range)


def _rounded(b: Builder, shifted: Value) -> Value:
    """At most the limit. A NaN loses against it, but makes r and so the polynomial NaN."""
    return b.op(Opcode.FMIN, shifted, ROUNDED_LIMIT)


def _scaled(b: Builder, value: Value, shifted: Value, in_range: Value) -> Value:
    """Far below the range r and n are meaningless: the predicated FMA passes its 0 through."""
    scale = b.op(Opcode.SHL, shifted, EXPONENT_SHIFT)
    return b.op(Opcode.FMA, value, scale, 0, pred=in_range)
