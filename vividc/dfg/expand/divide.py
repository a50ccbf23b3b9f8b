"""Division in operations of the array, correctly rounded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Generic

from vividc.dfg.expand.builder import (
    EXPONENT,
    EXPONENT_SHIFT,
    FINITE_NONZERO,
    ONE,
    SIGN,
    SMALLEST_NORMAL,
    Builder,
    Expansion,
)
from vividc.dfg.passes.rewrite import Value
from vividc.machine.division import Emit, V
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_MASK, float_of, word_of

# Subtracting a number's bits negates its exponent and makes a chord of 1/m of its mantissa; this
# constant balances the chord's error to +-5.06 % on all of [1, 2).
RECIPROCAL_MAGIC: Final = 0x7EF311C7
SUBNORMAL_EXPONENT: Final = -149  # of a subnormal number whose bits count as an integer
MANTISSA: Final = SMALLEST_NORMAL - 1
HALF_ULP: Final = 24 << EXPONENT_SHIFT  # of a quotient in [1, 2): what to take from an exponent
SUBNORMAL_BITS: Final = 24
SUBNORMAL_SCALE: Final = 0x4B800000  # 2**24, which makes any subnormal normal
# Exponents beyond +-200 overflow or vanish all the same, and half of these is an exponent
# of a normal number.
EXPONENT_LIMIT: Final = 200
SMALLEST_INVERTIBLE: Final = 2.0**-127
LARGEST_CONSTANT: Final = 2.0**24
LARGEST_ODD: Final = 1 << 21
SCALES: Final = 254 << EXPONENT_SHIFT  # the fields of a power of two and its inverse together
SMALLEST_SCALE: Final = 0x00400000  # 2**-127, the inverse of the largest
MINUS_ZERO: Final = SIGN
LIFT: Final = 48
LIFTED: Final = 127 + LIFT << EXPONENT_SHIFT  # 2**LIFT
_LIFT: Final = LIFT << EXPONENT_SHIFT  # of an exponent
_CONVERTED: Final = SUBNORMAL_EXPONENT << EXPONENT_SHIFT
UP: Final = 0x5F800000  # 2**64
DOWN: Final = 0x1F800000  # 2**-64
_MINUS_LIMIT: Final = -EXPONENT_LIMIT & WORD_MASK


def divide(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor: where latency binds in 52 operations, that take 37 cycles from the
    divisor and 25 from the dividend if the divisor is there last, else 43 and 18; elsewhere in 46
    that take 61 and 36; with the same words. In fewer for most constant divisors
    (`quotient_by_constant`).

    Correctly rounded (IEEE 754 round to nearest even) wherever the result is normal, infinite, zero
    or NaN; a subnormal result is rounded twice and has an error of at most 0.75 ulp. Nothing is
    flushed: subnormal operands count. The proofs are in the test, by cases of divisors.
    """
    word = b.word(divisor)
    by_constant = None if word is None else quotient_by_constant(b, dividend, word)
    if by_constant is not None:
        return by_constant
    if not b.latency_binds:
        return _divide_cheaply(b, dividend, divisor)
    if b.divisor_is_last or b.word(dividend) is not None:
        return _divide_late(b, dividend, divisor)
    known = prepared_soon(b.op, divisor, normal=b.has_normal_divisor)
    return quotient_soon_by(b.op, dividend, known)


def _divide_late(b: Builder, dividend: Value, divisor: Value) -> Value:
    """The quotient on a short path from the divisor.

    The magnitudes' mantissas are divided: an estimate of the reciprocal by an integer subtraction
    and a product of a geometric series, and a quotient that is less than one and a half units in
    the last place off, by a Newton step from the product with it: before that it is rounded by half
    a unit at most, as the estimate is never too high by more than its own roundings. Its exact
    residual, compared with half a unit times the divisor, tells whether it is the nearest number or
    which neighbour is. Nothing of that waits for exponents and signs, which are scales: one is
    added to the quotient's bits, and the last FMA multiplies by the other. Only that can round,
    overflow or underflow.
    """
    a, d = _unpacked(b, dividend), _unpacked(b, divisor, b.has_normal_divisor)
    y = _estimate(b.op, d.mantissa, d.fraction)
    near = b.op(Opcode.FMUL, a.mantissa, y)
    near = b.op(Opcode.FMA, near, b.op(Opcode.FNMA, d.mantissa, y, ONE), near)
    rest = b.op(Opcode.FNMA, d.mantissa, near, a.mantissa)
    first, second = _scales(b, b.op(Opcode.SUB, a.exponent, d.exponent))
    half = _half_ulp(b, a.mantissa, d.mantissa)
    above = b.op(Opcode.FCMP_OLE, half, rest)
    below = b.op(Opcode.FCMP_OLE, rest, b.op(Opcode.FNEG, half))
    scaled = b.stepped(b.op(Opcode.ADD, near, first), above, below)
    sign = b.op(Opcode.AND, b.op(Opcode.XOR, dividend, divisor), SIGN)
    finite = b.op(Opcode.AND, a.finite, d.finite)
    special = b.op(Opcode.SELECT, finite, 0, _special(b, dividend, divisor))
    return b.op(Opcode.FMA, scaled, b.op(Opcode.OR, second, sign), special, pred=finite)


def _divide_cheaply(b: Builder, dividend: Value, divisor: Value) -> Value:
    """The quotient in few operations.

    Signed mantissas are divided by an estimate of the reciprocal and two corrections by exact
    residuals (Markstein, "Computation of elementary functions on the IBM RISC System/6000
    processor", 1990).
    """
    a, exponent_a, small_a, finite_a = _signed_parts(b, dividend)
    d, exponent_d, small_d, finite_d = _signed_parts(b, divisor)
    # The fields differ by less than 2**31.
    exponent = b.op(Opcode.ASHR, b.op(Opcode.SUB, exponent_a, exponent_d), EXPONENT_SHIFT)
    exponent = b.op(Opcode.ADD, -SUBNORMAL_BITS & WORD_MASK, exponent, pred=small_a)
    exponent = b.op(Opcode.ADD, SUBNORMAL_BITS, exponent, pred=small_d)
    first, second = _scales(b, exponent)
    scaled = b.op(Opcode.FMUL, b.op(Opcode.ADD, _corrected_quotient(b, a, d), first), second)
    special = _special(b, dividend, divisor)
    value = b.op(Opcode.SELECT, finite_a, scaled, special)
    return b.op(Opcode.SELECT, finite_d, value, special)


def _special(b: Builder, dividend: Value, divisor: Value) -> Value:
    """The quotient of a zero, infinity or NaN, or by one.

    Infinity - bits turns 0 into infinity, infinity into 0, NaN into NaN and any other number into a
    finite one, all of the same sign.
    """
    return b.op(Opcode.FMUL, dividend, b.op(Opcode.SUB, EXPONENT, divisor))


def quotient_by_constant(b: Builder, dividend: Value, word: int) -> Value | None:
    """dividend / constant, rounded as by `divide`, in 1 operation if the constant is a power of two
    whose inverse is a number, in 4 if it is an integer (`_quotient_by_integer`), and in 13 to 16 if
    it is another from 2**-24 to 2**24 in magnitude.

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
    if _is_divided_soon(constant):
        return _quotient_by_integer(b, dividend, word, inverse)
    magnitude = b.op(Opcode.FABS, dividend)
    scales = [(b.op(Opcode.FCMP_OLT, magnitude, DOWN), UP, DOWN)]
    if abs(constant) < 1:
        scales.append((b.op(Opcode.FCMP_OLE, UP, magnitude), DOWN, UP))
    near = dividend
    for beyond, factor, _ in scales:
        near = b.op(Opcode.FMUL, factor, near, pred=beyond)
    value = b.op(Opcode.FMUL, near, inverse)
    for _ in range(2):
        rest = b.op(Opcode.FNMA, value, word, near)
        value = b.op(Opcode.FMA, rest, inverse, value)
    for beyond, _, factor in scales:
        value = b.op(Opcode.FMUL, factor, value, pred=beyond)
    special = b.op(Opcode.FMUL, dividend, inverse)
    return b.op(Opcode.SELECT, b.is_finite_nonzero(magnitude), value, special)


def _is_divided_soon(constant: float) -> bool:
    """Whether it is an integer whose odd part is below `LARGEST_ODD`."""
    whole = int(constant)
    return whole == constant and abs(whole // (whole & -whole)) < LARGEST_ODD


def _quotient_by_integer(b: Builder, dividend: Value, word: int, inverse: int) -> Value:
    """dividend / integer in 13 cycles.

    The product with the inverse is less than two units in the last place off, so that its residual,
    a multiple of a unit of the dividend's or of 2**-149, is exact whatever the dividend; nothing
    needs to be scaled. What the correction adds is off by 2**-24 of that, and a quotient by an odd
    number D is no nearer to a middle between two numbers than 1/(2D) of a unit (half that below a
    power of two). Of a zero the residual is 0, of infinity and NaN it is NaN: the product stands.
    """
    near = b.op(Opcode.FMUL, dividend, inverse)
    rest = b.op(Opcode.FNMA, near, word, dividend)
    return b.op(Opcode.FMA, rest, inverse, near, pred=b.op(Opcode.FCMP_ONE, rest, 0))


@dataclass(frozen=True, slots=True)
class Divisor(Generic[V]):
    """What quotients by one divisor d = m 2**e have in common.

    Attributes
    ----------
    mantissa, inverse
        m in [1, 2), with d's sign, and 1/m; of zero, infinity and NaN d itself, and what the
        dividend times which is the quotient.
    scale, small_scale
        2**-e and 2**(-e - LIFT), or a number that serves as well.
    """

    mantissa: V
    inverse: V
    scale: V
    small_scale: V


@dataclass(frozen=True, slots=True)
class SoonDivisor(Divisor[V]):
    """What `quotient_soon_by` needs beside it.

    Attributes
    ----------
    lifted_inverse
        2**LIFT / m, where `small_scale` is not 0.
    half, minus_half
        The magnitude of m times half a unit in the last place of 1, as bits to which an exponent is
        added, and minus that.
    """

    lifted_inverse: V
    half: V
    minus_half: V


def prepared(emit: Emit[V], divisor: V) -> Divisor[V]:
    """A divisor for `quotient_by`, in 24 operations that take 34 cycles."""
    magnitude = emit(Opcode.FABS, divisor)
    small = emit(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
    normal = emit(Opcode.SELECT, small, emit(Opcode.FMUL, SUBNORMAL_SCALE, divisor), divisor)
    exponent = emit(Opcode.AND, normal, EXPONENT)
    mantissa = emit(Opcode.ADD, emit(Opcode.SUB, normal, exponent), ONE)
    raised = SCALES - _LIFT + (SUBNORMAL_BITS << EXPONENT_SHIFT)
    lifted = emit(Opcode.SELECT, small, raised, SCALES - _LIFT)
    finite = emit(Opcode.ICMP_ULT, emit(Opcode.SUB, magnitude, 1), FINITE_NONZERO)
    return Divisor(
        emit(Opcode.SELECT, finite, mantissa, divisor),
        _or_special(emit, finite, _reciprocal(emit, mantissa, is_exact=True), divisor),
        *_inverse_scales(emit, exponent, SCALES, lifted),
    )


def prepared_soon(
    emit: Emit[V], divisor: V, *, exact: bool = False, normal: bool = False
) -> SoonDivisor[V]:
    """As `prepared`, in 31 operations that take 27 cycles, for `quotient_soon_by`.

    Parameters
    ----------
    exact
        For `quotient_by` too: an operation and 4 cycles more. Without a quotient by the other three
        of them are in no use.
    normal
        It cannot be subnormal, as roots cannot: 4 operations and 3 cycles less.
    """
    number = magnitude = emit(Opcode.FABS, divisor)
    finite = emit(Opcode.ICMP_ULT, emit(Opcode.SUB, magnitude, 1), FINITE_NONZERO)
    scales: V | int = SCALES
    if normal:
        lifted = emit(Opcode.SELECT, finite, SCALES - _LIFT, 0)
    else:
        small = emit(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
        number = emit(Opcode.SELECT, small, emit(Opcode.SITOFP, magnitude), magnitude)
        scales = emit(Opcode.SELECT, small, SCALES + ONE & WORD_MASK, SCALES)
        raised = SCALES - _LIFT - _CONVERTED & WORD_MASK
        lifted = emit(Opcode.SELECT, small, raised, SCALES - _LIFT)
    exponent = emit(Opcode.AND, number, EXPONENT)
    fraction = emit(Opcode.AND, number, MANTISSA)
    mantissa = emit(Opcode.OR, fraction, ONE)
    sign = emit(Opcode.AND, divisor, SIGN)
    inverse = _reciprocal(emit, mantissa, fraction, sign, is_exact=exact)
    half = emit(Opcode.SUB, mantissa, ONE + HALF_ULP)
    return SoonDivisor(
        emit(Opcode.SELECT, finite, emit(Opcode.OR, mantissa, sign), divisor),
        _or_special(emit, finite, inverse, divisor),
        *_inverse_scales(emit, exponent, scales, lifted),
        emit(Opcode.ADD, inverse, _LIFT),
        half,
        emit(Opcode.FNEG, half),
    )


def _or_special(emit: Emit[V], finite: V, inverse: V, divisor: V) -> V:
    """An inverse, or what takes its place as in `_special`."""
    return emit(Opcode.SELECT, finite, inverse, emit(Opcode.SUB, EXPONENT, divisor))


def _inverse_scales(emit: Emit[V], exponent: V, scales: V | int, lifted: V | int) -> tuple[V, V]:
    return (
        emit(Opcode.SMAX, emit(Opcode.SUB, scales, exponent), SMALLEST_SCALE),
        emit(Opcode.SMAX, emit(Opcode.SUB, lifted, exponent), 0),
    )


def _reciprocal(
    emit: Emit[V], d: V, fraction: V | None = None, sign: V | None = None, *, is_exact: bool
) -> V:
    """1 / d for a magnitude in [1, 2), perhaps with a sign: as near as one step needs, or two
    corrections of a quotient. `fraction`: as of `_estimate`.
    """
    y = _estimate(emit, d, fraction)
    error = emit(Opcode.FNMA, d, y, ONE)
    if is_exact:
        # Else y would be low by 4e-11, too much where 1/d is half-way between two numbers.
        error = emit(Opcode.FMA, error, error, error)
    if sign is not None:
        y = emit(Opcode.OR, y, sign)
    return emit(Opcode.FMA, y, error, y)


def quotient_by(emit: Emit[V], dividend: V, divisor: Divisor[V]) -> V:
    """dividend / divisor, the words of `divide`, in 11 operations that take 30 cycles from the
    dividend.

    The dividend is divided by m as by `_divide_cheaply`, and the quotient scaled, which alone can
    round again, overflow or underflow. Residuals are exact where the dividend is at least 2**-102:
    one below 2**(-e - LIFT) is lifted by 2**LIFT, and where e is so large that others are smaller
    yet, their quotients vanish. So do those of lifted ones where `small_scale` is 0, as e > 78.
    Where d is subnormal, `scale` is not what it should be, but the quotients by d of what is
    not lifted overflow all the same; and what overflows as it is lifted does so as a quotient.

    Of zero, infinity and NaN, among dividends and divisors, the first residual is 0 or NaN, and the
    product with the inverse stands. The last operation is an FMA, so that no sum takes it in.
    """
    small = emit(Opcode.FCMP_OLT, emit(Opcode.FABS, dividend), divisor.small_scale)
    near = emit(Opcode.SELECT, small, emit(Opcode.FMUL, LIFTED, dividend), dividend)
    value = emit(Opcode.FMUL, near, divisor.inverse)
    rest = emit(Opcode.FNMA, value, divisor.mantissa, near)
    inexact = emit(Opcode.FCMP_ONE, rest, 0)
    for last in (False, True):
        corrected = emit(Opcode.FMA, rest, divisor.inverse, value)
        value = emit(Opcode.SELECT, inexact, corrected, value)
        if not last:
            rest = emit(Opcode.FNMA, value, divisor.mantissa, near)
    scale = emit(Opcode.SELECT, small, divisor.small_scale, divisor.scale)
    return emit(Opcode.FMA, value, scale, MINUS_ZERO)


def quotient_soon_by(emit: Emit[V], dividend: V, divisor: SoonDivisor[V]) -> V:
    """As `quotient_by`, in 20 operations that take 18 cycles from the dividend.

    The product of the dividend's magnitude and the inverse, one of which is lifted, goes one step
    up or down, as in `_divide_late`. The half of its last place is told by its own exponent, or
    downwards by that of the number below. Of a zero that would be a negative number, so that zero
    would step up. What is smaller than a residual can tell vanishes as a quotient, and a step
    further.
    """
    magnitude = emit(Opcode.FABS, dividend)
    small = emit(Opcode.FCMP_OLT, magnitude, divisor.small_scale)
    inverse = emit(Opcode.SELECT, small, divisor.lifted_inverse, divisor.inverse)
    near = emit(Opcode.FMUL, magnitude, inverse)
    a = emit(Opcode.SELECT, small, emit(Opcode.FMUL, LIFTED, magnitude), magnitude)
    rest = emit(Opcode.FNMA, near, divisor.mantissa, a)
    up = emit(Opcode.ADD, emit(Opcode.AND, near, EXPONENT), divisor.half)
    under = emit(Opcode.AND, emit(Opcode.SUB, near, 1), EXPONENT)
    down = emit(Opcode.ADD, under, divisor.minus_half)
    above = emit(Opcode.FCMP_OLE, emit(Opcode.SMAX, up, 1), rest)
    below = emit(Opcode.FCMP_OLE, rest, down)
    stepped = emit(Opcode.SUB, emit(Opcode.ADD, near, above), below)
    scale = emit(Opcode.SELECT, small, divisor.small_scale, divisor.scale)
    signed = emit(Opcode.OR, scale, emit(Opcode.AND, dividend, SIGN))
    return emit(Opcode.FMA, stepped, signed, MINUS_ZERO)


def quotient(b: Builder, dividend: Value, divisor: Value) -> Value:
    """dividend / divisor in 8 operations, to 0.501 ulp, where the divisor and its reciprocal are
    normal and no intermediate product overflows or underflows.
    """
    y = reciprocal_estimate(b, divisor)
    near = b.op(Opcode.FMUL, dividend, y)
    return b.op(Opcode.FMA, b.op(Opcode.FNMA, divisor, near, dividend), y, near)


def reciprocal_estimate(b: Builder, divisor: Value) -> Value:
    """1 / divisor to 6.7e-6 in 13 cycles."""
    return _estimate(b.op, divisor)


def _estimate(emit: Emit[V], divisor: V, fraction: V | None = None) -> V:
    """1 / divisor to 6.7e-6; of a mantissa in [1, 2), whose bits after the point may be there
    earlier.

    With y of an integer subtraction and e = 1 - divisor * y, it is y (1 + e) (1 + e**2), whose
    relative error is e**4 (Goldschmidt, "Applications of division by convergence", 1964): the
    square of e is there as soon as the first product is.
    """
    if fraction is None:
        y = emit(Opcode.SUB, RECIPROCAL_MAGIC, divisor)
    else:
        y = emit(Opcode.SUB, RECIPROCAL_MAGIC - ONE, fraction)
    error = emit(Opcode.FNMA, divisor, y, ONE)
    y = emit(Opcode.FMA, y, error, y)
    return emit(Opcode.FMA, y, emit(Opcode.FMUL, error, error), y)


@dataclass(frozen=True, slots=True)
class _Unpacked:
    """A magnitude's mantissa in [1, 2), the bits of it after the point, its biased exponent, and
    whether it is finite and not 0.
    """

    mantissa: Value
    fraction: Value
    exponent: Value
    finite: Value


def _unpacked(b: Builder, x: Value, is_normal: bool = False) -> _Unpacked:
    """A subnormal number is converted as the integer that its bits are."""
    number = magnitude = b.op(Opcode.FABS, x)
    if not is_normal:
        small = b.op(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
        number = b.op(Opcode.SITOFP, magnitude, pred=small)
    fraction = b.op(Opcode.AND, number, MANTISSA)
    exponent = b.op(Opcode.LSHR, number, EXPONENT_SHIFT)
    if not is_normal:
        exponent = b.op(Opcode.ADD, SUBNORMAL_EXPONENT & WORD_MASK, exponent, pred=small)
    mantissa = b.op(Opcode.OR, fraction, ONE)
    return _Unpacked(mantissa, fraction, exponent, b.is_finite_nonzero(magnitude))


def _signed_parts(b: Builder, x: Value) -> tuple[Value, Value, Value, Value]:
    """Signed mantissa in [1, 2), exponent field, and whether x was subnormal, and finite not 0."""
    magnitude = b.op(Opcode.FABS, x)
    small = b.op(Opcode.ICMP_ULT, magnitude, SMALLEST_NORMAL)
    normal = b.op(Opcode.FMUL, SUBNORMAL_SCALE, x, pred=small)
    exponent = b.op(Opcode.AND, normal, EXPONENT)
    mantissa = b.op(Opcode.ADD, b.op(Opcode.SUB, normal, exponent), ONE)
    return mantissa, exponent, small, b.is_finite_nonzero(magnitude)


def _corrected_quotient(b: Builder, a: Value, d: Value) -> Value:
    """a / d for magnitudes in [1, 2), correctly rounded."""
    y = _reciprocal(b.op, d, is_exact=True)
    near = b.op(Opcode.FMUL, a, y)
    for _ in range(2):  # to within half an ulp and a little, then to the nearest
        near = b.op(Opcode.FMA, b.op(Opcode.FNMA, d, near, a), y, near)
    return near


def _half_ulp(b: Builder, a: Value, d: Value) -> Value:
    """d times half a unit in the last place of a / d, which is below 1 where a is below d."""
    half = b.op(Opcode.SUB, d, HALF_ULP)
    less = b.op(Opcode.ICMP_ULT, a, d)
    return b.op(Opcode.ADD, -SMALLEST_NORMAL & WORD_MASK, half, pred=less)


def _scales(b: Builder, exponent: Value) -> tuple[Value, Value]:
    """What to add to the bits of a number between 1/2 and 2, and what to multiply it by then, for
    its product with 2**exponent.
    """
    exponent = b.op(Opcode.SMIN, b.op(Opcode.SMAX, exponent, _MINUS_LIMIT), EXPONENT_LIMIT)
    half = b.op(Opcode.ASHR, exponent, 1)
    rest = b.op(Opcode.SUB, exponent, half)
    scale = b.op(Opcode.ADD, b.op(Opcode.SHL, rest, EXPONENT_SHIFT), ONE)
    return b.op(Opcode.SHL, half, EXPONENT_SHIFT), scale


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.FDIV: divide,
}
