"""exp(x) - 1 and the hyperbolic functions in operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT_SHIFT, ONE, SIGN, Builder, Expansion
from vividc.dfg.expand.divide import quotient
from vividc.dfg.expand.exp import LOG2_E, MINUS_LN2_HIGH, MINUS_LN2_LOW
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

# All words are binary32 bits. 1.5 * 2**23 + b: added to a float below 2**22 it leaves the rounded
# integer, b higher, in the low bits. 126 makes the scale 2**(n - 1), 127 makes it 2**n.
ROUNDING_126: Final = 0x4B40007E
ROUNDING_127: Final = 0x4B40007F
ROUNDING_125: Final = 0x4B40007D
LIMIT: Final = 0x4B4000FE  # the scale is 2**127
HALF: Final = 0x3F000000
MINUS_ONE: Final = 0xBF800000
TWO: Final = 0x40000000
SMALLEST: Final = 0xC1A00000  # -20: exp(x) - 1 rounds to -1
LARGEST_TANH: Final = 0x41200000  # 10: tanh(x) rounds to 1
LARGEST_HYPERBOLIC: Final = 0x42B33333  # 89.6: cosh and sinh overflow from 89.42 on
SCALES: Final = 250 << EXPONENT_SHIFT  # 2**(n - 2) and 2**(-n - 2) add up to it as words
# (expm1(r) - r) / r**2 on |r| <= ln(2) / 2, from the highest power to the constant; relative to
# expm1 the error is 2**-31.0. This and the next two: least squares at 400 Chebyshev points, weights
# r**2 / expm1(r) here, u there, the coefficients rounded one after the other from the constant on.
EXPM1: Final = (0x394F03D6, 0x3AB6A1BB, 0x3C088984, 0x3D2AAA78, 0x3E2AAAAA, 0x3F000000)
# (cosh(r) - 1) / u and (sinh(r) / r - 1) / u with u = r**2, on the same interval: 2**-33.2, -34.1.
COSH: Final = (0x3AB6A8AD, 0x3D2AAA72, 0x3F000000)
SINH: Final = (0x3951479A, 0x3C0887F1, 0x3E2AAAAB)


def exponential_minus_one(b: Builder, x: Value) -> Value:
    """expm1(x): with n and r as for `exponential`, 2 (2**(n-1) expm1(r) + (2**(n-1) - 1/2))."""
    low = b.op(Opcode.FCMP_OLT, x, SMALLEST)
    near = b.op(Opcode.SELECT, low, SMALLEST, x)
    half_scale, p = _reduced_expm1(b, near, ROUNDING_126)
    rest = b.op(Opcode.FSUB, half_scale, HALF)
    value = b.op(Opcode.FMA, half_scale, p, rest)
    value = b.op(Opcode.OR, value, b.op(Opcode.AND, x, SIGN))  # of -0
    return b.op(Opcode.FADD, value, value)


def hyperbolic_tangent(b: Builder, x: Value) -> Value:
    """tanh(x) = e / (e + 2) with e = expm1(2 |x|)."""
    near = b.clamped(b.op(Opcode.FABS, x), LARGEST_TANH)
    scale, p = _reduced_expm1(b, b.op(Opcode.FADD, near, near), ROUNDING_127)
    e = b.op(Opcode.FMA, scale, p, b.op(Opcode.FADD, scale, MINUS_ONE))
    return b.times_sign(quotient(b, e, b.op(Opcode.FADD, e, TWO)), x)


def hyperbolic_cosine(b: Builder, x: Value) -> Value:
    """cosh(x) = 2 (S cosh(r) + D sinh(r)) with S, D = (2**n +- 2**-n) / 4."""
    total, difference, cosh, sinh = _parts(b, x)
    value = b.op(Opcode.FMA, total, cosh, b.op(Opcode.FMUL, difference, sinh))
    return b.op(Opcode.FADD, value, value)


def hyperbolic_sine(b: Builder, x: Value) -> Value:
    """sinh(x) = 2 (D cosh(r) + S sinh(r)), as `hyperbolic_cosine`."""
    total, difference, cosh, sinh = _parts(b, x)
    value = b.op(Opcode.FMA, difference, cosh, b.op(Opcode.FMUL, total, sinh))
    value = b.op(Opcode.OR, value, b.op(Opcode.AND, x, SIGN))  # of -0
    return b.op(Opcode.FADD, value, value)


def _reduced_expm1(b: Builder, x: Value, magic: int) -> tuple[Value, Value]:
    """The scale and expm1(r)."""
    shifted = b.op(Opcode.FMIN, b.op(Opcode.FMA, x, LOG2_E, magic), LIMIT)
    r = _reduced(b, x, shifted, magic)
    p = b.op(Opcode.FMA, b.op(Opcode.FMUL, r, r), b.horner(EXPM1, r), r)
    return b.op(Opcode.SHL, shifted, EXPONENT_SHIFT), p


def _reduced(b: Builder, x: Value, shifted: Value, magic: int) -> Value:
    """x - n ln 2."""
    n = b.op(Opcode.FSUB, shifted, magic)
    return b.op(Opcode.FMA, n, MINUS_LN2_LOW, b.op(Opcode.FMA, n, MINUS_LN2_HIGH, x))


def _parts(b: Builder, x: Value) -> tuple[Value, Value, Value, Value]:
    """S, D, cosh(r) and sinh(r) of |x| = n ln 2 + r."""
    near = b.clamped(b.op(Opcode.FABS, x), LARGEST_HYPERBOLIC)
    shifted = b.op(Opcode.FMA, near, LOG2_E, ROUNDING_125)
    r = _reduced(b, near, shifted, ROUNDING_125)
    up = b.op(Opcode.SHL, shifted, EXPONENT_SHIFT)
    down = b.op(Opcode.SMAX, b.op(Opcode.SUB, SCALES, up), 0)
    total, difference = b.op(Opcode.FADD, up, down), b.op(Opcode.FSUB, up, down)
    u = b.op(Opcode.FMUL, r, r)
    cosh = b.op(Opcode.FMA, b.horner(COSH, u), u, ONE)
    sinh = b.op(Opcode.FMA, b.op(Opcode.FMUL, r, u), b.horner(SINH, u), r)
    return total, difference, cosh, sinh


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.EXPM1: exponential_minus_one,
    Opcode.SINH: hyperbolic_sine,
    Opcode.COSH: hyperbolic_cosine,
    Opcode.TANH: hyperbolic_tangent,
}
