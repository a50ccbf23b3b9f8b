"""Integer division in operations of the array: quotients and remainders of two variables.

Words are unsigned unless said otherwise. By zero the quotient is 0 and the remainder the dividend.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from vividc.dfg.expand.builder import Builder, Expansion
from vividc.dfg.passes.rewrite import Value
from vividc.machine.division import Emit, quotient_by_constant, remainder_by_constant
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_MASK, signed

# Subtracting a binary32 number's bits from this gives about 2**32 over the number, within 5.06 %:
# `RECIPROCAL_MAGIC` of the float division with an exponent that is 32 higher.
RECIPROCAL_WORD_MAGIC: Final = 0x8EF311C7
_SIGN_SHIFT: Final = 31


class _Division(NamedTuple):
    """A quotient that is right or low by one, what it leaves, and whether it is low."""

    quotient: Value
    rest: Value
    low: Value
    minus_divisor: Value


def unsigned_quotient(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor in 23 operations, 26 cycles with integer multiplications and conversions
    of 2; see `_divide` for why it is exact.
    """
    constant = b.word(divisor)
    if constant is not None:
        return _by_constant(b, Opcode.UDIV, dividend, constant)
    division = _divide(b, dividend, divisor)
    return b.op(Opcode.ADD, division.quotient, division.low)


def unsigned_remainder(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend % divisor in 22 operations, all but one of them the quotient's."""
    constant = b.word(divisor)
    if constant is not None:
        return _by_constant(b, Opcode.UREM, dividend, constant)
    division = _divide(b, dividend, divisor)
    return b.op(Opcode.ADD, division.minus_divisor, division.rest, pred=division.low)


def signed_quotient(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor towards zero, from the magnitudes; INT_MIN / -1 wraps to INT_MIN."""
    constant = b.word(divisor)
    if constant is not None and signed(constant) > 0:
        return _signed_by_constant(b, Opcode.UDIV, dividend, constant)
    magnitudes = _magnitude(b, dividend), _magnitude(b, divisor)
    sign = b.op(Opcode.ASHR, b.op(Opcode.XOR, dividend, divisor), _SIGN_SHIFT)
    return _with_sign(b, unsigned_quotient(b, *magnitudes), sign)


def signed_remainder(b: Builder, dividend: Value, divisor: Value) -> Value:
    """What the signed quotient leaves: it has the dividend's sign."""
    constant = b.word(divisor)
    if constant is not None and signed(constant) > 0:
        return _signed_by_constant(b, Opcode.UREM, dividend, constant)
    remainder = unsigned_remainder(b, _magnitude(b, dividend), _magnitude(b, divisor))
    return _with_sign(b, remainder, b.op(Opcode.ASHR, dividend, _SIGN_SHIFT))


def _divide(b: Builder, dividend: Value, divisor: Value) -> _Division:
    """Long division by a reciprocal x <= 2**32 / divisor, twice: x times what is left, rounded
    down, is the next part of the quotient.

    Let t = (2**32 - x * divisor) / 2**32. A part q of a rest n leaves less than n * t + divisor, so
    the second leaves less than 2**32 * t**2 + divisor * t + divisor. That is at most twice the
    divisor, and one conditional subtraction ends the division, if

        x * divisor <= 2**32 and t * (2**32 * t + divisor) <= divisor,

    which was tried for every divisor from 1 to 2**31 - 1: the left side is at most 0.667 times the
    right one. From 2**31 on x is 0 or 1, the parts are 0, and the quotient is 0 or 1.
    By zero x is 0, and so is the quotient.
    """
    x, minus_divisor = _reciprocal(b, divisor)
    first = b.op(Opcode.MULHU, dividend, x)
    rest = b.op(Opcode.ADD, dividend, b.op(Opcode.MUL, first, minus_divisor))
    second = b.op(Opcode.MULHU, rest, x)
    rest = b.op(Opcode.ADD, rest, b.op(Opcode.MUL, second, minus_divisor))
    # rest >= divisor, but false for the divisor 0.
    low = b.op(Opcode.ICMP_ULT, b.op(Opcode.SUB, divisor, 1), rest)
    return _Division(b.op(Opcode.ADD, first, second), rest, low, minus_divisor)


def _reciprocal(b: Builder, divisor: Value) -> tuple[Value, Value]:
    """About 2**32 / divisor, never more, in 13 operations; and the divisor's negative.

    The float of the divisor gives an estimate within 5.06 % and a unit. The error t (in units of
    2**-32, read as signed) comes from one multiplication; x (1 + t)(1 + t**2) has the error t**4
    (Goldschmidt, "Applications of division by convergence", 1964), and the squaring of t runs
    beside the first product.
    """
    bits = b.op(Opcode.SUB, RECIPROCAL_WORD_MAGIC, b.op(Opcode.UITOFP, divisor))
    estimate = b.op(Opcode.FPTOSI, bits)
    # Just below 2**31 the estimate is sometimes 1 where 2 is needed.
    is_positive = b.op(Opcode.ICMP_SLT, 0, divisor)
    x = b.op(Opcode.SMAX, 2, estimate, pred=is_positive)
    minus_divisor = b.op(Opcode.SUB, 0, divisor)
    # By 1 and 0 the reciprocals are 2**32 - 1 and 0, the divisors' negatives: each operation
    # passes the one before it.
    regular = b.op(Opcode.ICMP_ULT, 1, divisor)
    error = b.op(Opcode.MUL, x, minus_divisor, pred=regular)
    step = b.op(Opcode.MULHS, x, error, pred=regular)
    squared = b.op(Opcode.MULHS, error, error)
    x = b.op(Opcode.ADD, x, step, pred=regular)
    return b.op(Opcode.ADD, b.op(Opcode.MULHU, x, squared), x, pred=regular), minus_divisor


def _by_constant(b: Builder, op: Opcode, dividend: Value, divisor: int) -> Value:
    emit: Emit[Value] = b.op
    if divisor == 0:
        return b.op(Opcode.MOV, 0 if op is Opcode.UDIV else dividend)
    rule = quotient_by_constant if op is Opcode.UDIV else remainder_by_constant
    result = rule(emit, dividend, divisor, WORD_MASK)
    # `Expansion` promises an operation.
    return b.op(Opcode.MOV, result) if isinstance(result, int) or result == dividend else result


def _signed_by_constant(b: Builder, op: Opcode, dividend: Value, divisor: int) -> Value:
    """By a positive constant: magnitudes are at most 2**31."""
    sign = b.op(Opcode.ASHR, dividend, _SIGN_SHIFT)
    rule = quotient_by_constant if op is Opcode.UDIV else remainder_by_constant
    emit: Emit[Value] = b.op
    result = rule(emit, _magnitude(b, dividend), divisor, 1 << _SIGN_SHIFT)
    return _with_sign(b, result, sign)


def _magnitude(b: Builder, x: Value) -> Value:
    """|x|; that of INT_MIN is 2**31."""
    return b.op(Opcode.SMAX, x, b.op(Opcode.SUB, 0, x))


def _with_sign(b: Builder, magnitude: Value | int, sign: Value) -> Value:
    """The magnitude, negated where the sign is -1 and not 0."""
    return b.op(Opcode.SUB, b.op(Opcode.XOR, magnitude, sign), sign)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.UDIV: unsigned_quotient,
    Opcode.UREM: unsigned_remainder,
    Opcode.SDIV: signed_quotient,
    Opcode.SREM: signed_remainder,
}
