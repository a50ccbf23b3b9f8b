"""Logarithms in operations of the array."""

from __future__ import annotations

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
from vividc.machine.words import WORD_MASK

# All words are binary32 bits.
ROOT_HALF: Final = 0x3F3504F3  # sqrt(1/2): mantissas are taken in [sqrt(1/2), sqrt(2))
EXPONENT_AND_SIGN: Final = EXPONENT | SIGN
SUBNORMAL_SCALE: Final = 0x4B800000  # 2**24, which makes any subnormal normal
MINUS_SUBNORMAL_EXPONENT: Final = -(24 << EXPONENT_SHIFT) & WORD_MASK
MINUS_HALF: Final = 0xBF000000
MINUS_ONE: Final = 0xBF800000
MINUS_INFINITY: Final = EXPONENT | SIGN
# (log1p(f) - f + f**2 / 2) / f**3 on [sqrt(1/2) - 1, sqrt(2) - 1], from the highest power to the
# constant; relative to log1p the error is 2**-27.1 (least squares at 400 Chebyshev points with the
# weight |f**3 / log1p(f)|, the coefficients rounded one after the other from the constant on).
POLYNOMIAL: Final = (
    0xBD969B1B,
    0x3E012DF5,
    0xBE073413,
    0x3E11B21C,
    0xBE2A33C8,
    0x3E4CCC30,
    0xBE80011E,
    0x3EAAAAB2,
)
# Exponents are multiplied while still in their field, 2**23 too large.
LN2: Final = 0x3F317218 - (23 << EXPONENT_SHIFT)  # 2**-28.4 off
TWO_TO_MINUS_23: Final = 0x34000000
LOG10_2_HIGH: Final = 0x3E9A209B - (23 << EXPONENT_SHIFT)
LOG10_2_LOW: Final = 0xB2760860 - (23 << EXPONENT_SHIFT)
LOG2_E_HIGH: Final = 0x3FB8AA3B
LOG2_E_LOW: Final = 0x32A57060
LOG10_E_HIGH: Final = 0x3EDE5BD9
LOG10_E_LOW: Final = 0xB22D91AF


def natural_logarithm(b: Builder, x: Value) -> Value:
    """log(x) = k ln 2 + log1p(f), x = 2**k (1 + f)."""
    k, f = _split(b, x)
    log = b.op(Opcode.FADD, f, log1p_tail(b, f))
    return _finish(b, x, b.op(Opcode.FMA, k, LN2, log))


def binary_logarithm(b: Builder, x: Value) -> Value:
    """log2(x) = k + log1p(f) log2(e), powers of two exactly."""
    k, f = _split(b, x)
    log = _to_base(b, f, LOG2_E_HIGH, LOG2_E_LOW)
    return _finish(b, x, b.op(Opcode.FMA, k, TWO_TO_MINUS_23, log))


def decimal_logarithm(b: Builder, x: Value) -> Value:
    """log10(x) = k log10(2) + log1p(f) log10(e)."""
    k, f = _split(b, x)
    log = b.op(Opcode.FMA, k, LOG10_2_LOW, _to_base(b, f, LOG10_E_HIGH, LOG10_E_LOW))
    return _finish(b, x, b.op(Opcode.FMA, k, LOG10_2_HIGH, log))


def logarithm_of_successor(b: Builder, x: Value) -> Value:
    """log1p(x): the logarithm of u = 1 + x, whose rounding error is added to f (Kahan; as in
    fdlibm's s_log1p, 1993).
    """
    u = b.op(Opcode.FADD, x, ONE)
    bits, mantissa = split_exponent(b, u)
    rest = b.op(Opcode.FSUB, x, b.op(Opcode.FADD, u, MINUS_ONE))
    # 2**-k; where that would leave the normal numbers the rest is 0.
    scale = b.op(Opcode.SMAX, b.op(Opcode.SUB, ONE, bits), 0)
    f = b.op(Opcode.FMA, rest, scale, b.op(Opcode.FADD, mantissa, MINUS_ONE))
    log = b.op(Opcode.FADD, f, log1p_tail(b, f))
    log = b.op(Opcode.FMA, b.op(Opcode.SITOFP, bits), LN2, log)
    with_sign = b.op(Opcode.OR, log, b.op(Opcode.AND, x, SIGN))  # of -0
    return _finish(b, u, with_sign)


def split_exponent(b: Builder, x: Value) -> tuple[Value, Value]:
    """k in the place of the exponent field, and the mantissa in [sqrt(1/2), sqrt(2)), of a normal
    positive x.
    """
    bits = b.op(Opcode.AND, b.op(Opcode.SUB, x, ROOT_HALF), EXPONENT_AND_SIGN)
    return bits, b.op(Opcode.SUB, x, bits)


def split_positive(b: Builder, x: Value) -> tuple[Value, Value]:
    """As `split_exponent` of any finite x > 0, with k 2**23 as a float; garbage of another x, but
    finite.
    """
    small = b.op(Opcode.ICMP_ULT, x, SMALLEST_NORMAL)
    normal = b.op(Opcode.FMUL, SUBNORMAL_SCALE, x, pred=small)
    bits, mantissa = split_exponent(b, normal)
    bits = b.op(Opcode.ADD, MINUS_SUBNORMAL_EXPONENT, bits, pred=small)
    return b.op(Opcode.SITOFP, bits), mantissa


def log1p_tail(b: Builder, f: Value) -> Value:
    """log1p(f) - f."""
    inner = b.op(Opcode.FMA, b.horner(POLYNOMIAL, f), f, MINUS_HALF)
    return b.op(Opcode.FMUL, b.op(Opcode.FMUL, f, f), inner)


def _split(b: Builder, x: Value) -> tuple[Value, Value]:
    """k 2**23 and f, which is exact."""
    k, mantissa = split_positive(b, x)
    return k, b.op(Opcode.FADD, mantissa, MINUS_ONE)


def _to_base(b: Builder, f: Value, high: int, low: int) -> Value:
    """log1p(f) * (high + low), where only the product with f needs both."""
    tail = b.op(Opcode.FMUL, log1p_tail(b, f), high)
    return b.op(Opcode.FMA, f, high, b.op(Opcode.FMA, f, low, tail))


def _finish(b: Builder, x: Value, value: Value) -> Value:
    """The value where x is positive and finite; -infinity at 0, NaN below."""
    # infinity stays, negative numbers and NaNs become NaN.
    special = b.op(Opcode.FMA, x, EXPONENT, EXPONENT)
    pole = b.op(Opcode.FCMP_OEQ, x, 0)
    special = b.op(Opcode.SELECT, pole, MINUS_INFINITY, special)
    return b.op(Opcode.SELECT, b.is_finite_nonzero(x), value, special)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.LOG: natural_logarithm,
    Opcode.LOG2: binary_logarithm,
    Opcode.LOG10: decimal_logarithm,
    Opcode.LOG1P: logarithm_of_successor,
}
