"""exp and exp2 in operations of the array, also with a float16 or float8 number as the result.

The argument is always float32, and a narrow result is converted back to float32. The fewer bits it
has, the fewer terms it takes: a cubic for float16, and for float8 the straight line that the code
of a number is of its logarithm between two powers of two.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from vividc.dfg.expand.builder import EXPONENT_SHIFT, Builder, Expansion
from vividc.dfg.passes.rewrite import Value
from vividc.formats import E4M3, E5M2, F16, Format
from vividc.machine.opcodes import Opcode
from vividc.machine.words import word_of

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
# 2 * 2**r on |r| <= 1/2, relative error 2**-13.6, from the highest power to the constant (weighted
# least squares at 400 Chebyshev points, the coefficients rounded one after the other from the
# constant on).
CUBIC: Final = (0x3DE1A4BB, 0x3EF86D2E, 0x3FB17A8D, 0x3FFFFB58)
SMALLEST_OF_HALF: Final = 0xC1E00000  # -28.0: exp and exp2 are 0 in float16 below
# 1.5 * 2**15: added to a float below 2**14 it leaves 8 bits of fraction in the lowest byte and the
# integer above it.
FRACTION_MAGIC: Final = 49152.0
# A quiet NaN whose low bits name lane 1: of a NaN the lane number passes through.
LANE_OR_NAN: Final = 0x7FC00001
LINE_DROP: Final = {E4M3: 0.36, E5M2: 0.22}
"""How much lower than through the powers of two the line lies, in codes: it halves the error."""


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


def exponential_in(opcode: Opcode, fmt: Format) -> Expansion:
    """The expansion of `EXP` or `EXP2` in a format.

    float16: 12 operations, within 0.75 units in the last place. E4M3 and E5M2: 5 operations (after
    Schraudolph, "A fast, compact approximation of the exponential function", 1999), within 0.84 and
    0.65 units in the last place where the result is a normal number; below (2**-6, 2**-14) it falls
    to 0 on the line, at most 4.4 and 2.3 units too low. Overflow as of every operation of the
    format: infinity, or 448 of E4M3. NaN gives NaN.
    """
    if fmt is F16:
        return _half(_EXPONENT[opcode])
    return _line(fmt, _PER_UNIT[opcode])


def _exponent_of_exp(b: Builder, x: Value) -> tuple[Value, Value]:
    """round(x / ln 2) and the rest, in the words that `_half` goes on with."""
    shifted = b.op(Opcode.FMIN, b.op(Opcode.FMA, x, LOG2_E, ROUNDING_MAGIC), ROUNDED_LIMIT)
    minus_n = b.op(Opcode.FSUB, ROUNDING_MAGIC, shifted)
    return shifted, b.op(Opcode.FMA, x, LOG2_E, minus_n)


def _exponent_of_exp2(b: Builder, x: Value) -> tuple[Value, Value]:
    shifted = b.op(Opcode.FMIN, b.op(Opcode.FADD, x, ROUNDING_MAGIC), ROUNDED_LIMIT)
    minus_n = b.op(Opcode.FSUB, ROUNDING_MAGIC, shifted)
    return shifted, b.op(Opcode.FADD, x, minus_n)


_EXPONENT: Final = {Opcode.EXP: _exponent_of_exp, Opcode.EXP2: _exponent_of_exp2}
_PER_UNIT: Final = {Opcode.EXP: 1.0 / math.log(2.0), Opcode.EXP2: 1.0}
"""Powers of two for each 1 of the argument."""


def _half(exponent: Callable[[Builder, Value], tuple[Value, Value]]) -> Expansion:
    """As `exp` does it, with one step of range reduction and a cubic."""

    def expand(b: Builder, x: Value) -> Value:
        shifted, r = exponent(b, x)
        scale = b.op(Opcode.SHL, shifted, EXPONENT_SHIFT)
        in_range = b.op(Opcode.FCMP_ULE, SMALLEST_OF_HALF, x)
        value = b.op(Opcode.FMA, b.horner(CUBIC, r), scale, 0, pred=in_range)
        return b.op(Opcode.FPEXT_F16, b.op(Opcode.FPTRUNC_F16, value))

    return expand


def _line(fmt: Format, per_unit: float) -> Expansion:
    """The code is that of 1 and, for each power of two, as many codes more as a mantissa has."""
    mantissas = 1 << fmt.mantissa_bits
    one = fmt.bias * mantissas
    slope = word_of(per_unit * mantissas)
    # The conversion drops the fraction: half a code more makes it round.
    start = word_of(FRACTION_MAGIC + one + 0.5 - LINE_DROP[fmt])
    least = word_of(FRACTION_MAGIC)
    most = least + (fmt.overflow << 8 | 0xFF)
    unpack = Opcode(f"unpack.{fmt.name}x4")

    def expand(b: Builder, x: Value) -> Value:
        code = b.op(Opcode.FMA, x, slope, start)
        # As integers positive floats keep their order, and negative ones are below them.
        code = b.op(Opcode.SMIN, b.op(Opcode.SMAX, code, least), most)
        is_number = b.op(Opcode.FCMP_ORD, x, x)
        return b.op(unpack, code, LANE_OR_NAN, pred=is_number)

    return expand


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.EXP: exponential,
    Opcode.EXP2: power_of_two,
}
