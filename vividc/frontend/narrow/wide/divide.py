"""Division and remainder of 64-bit integers: exact, without a loop.

By a constant: multiply by its reciprocal 2**64 / d, rounded down, and correct (Granlund and
Montgomery, "Division by invariant integers using multiplication", 1994). By a variable: the
reciprocal comes from a float32 estimate and two Newton steps in integers, each of which doubles the
correct bits; what depends on the divisor only leaves the loops in which it does not change.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.frontend.narrow.wide.shifts import ashr, lshr
from vividc.frontend.narrow.wide.words import ZERO, Pair, Words
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Const, Instr, Int, Value

_BITS = 64
_LIMIT = 1 << _BITS
_NOTHING = Pair(ZERO, ZERO)
_SIGNED = frozenset({"sdiv", "srem"})
_QUOTIENTS = frozenset({"sdiv", "udiv"})
_DROPPED_CARRIES = 2  # what a high product can lack if the carries of its low part are left out


@dataclass(frozen=True, slots=True)
class _Division:
    """Quotient and remainder of magnitudes."""

    quotient: Pair
    remainder: Pair


def divide(w: Words, op: Instr) -> Pair:
    """sdiv, udiv, srem, urem. Division by 0 gives some integer: LLVM leaves it undefined."""
    value, divisor = op.operands
    signed = op.op in _SIGNED
    if isinstance(divisor, Int):
        magnitude = abs(divisor.value) if signed else divisor.value % _LIMIT
        if magnitude & (magnitude - 1) == 0:
            return _by_power(w, op, magnitude, negative=signed and divisor.value < 0)
    dividend, sign = _magnitude(w, value, signed=signed)
    d, divisor_sign = _magnitude(w, divisor, signed=signed)
    result = _by_magnitude(w, dividend, d)
    if op.op in _QUOTIENTS:
        return _signed(w, result.quotient, w.op(Opcode.XOR, sign, divisor_sign))
    return _signed(w, result.remainder, sign)


def divide_down(w: Words, op: Instr) -> Pair:
    """sfloordiv, sfloorrem, ufloordiv, ufloorrem: as Python rounds, and 0 by zero."""
    value, divisor = op.operands
    signed, is_quotient = op.mnemonic[0] == "s", op.mnemonic.endswith("div")
    dividend, sign = _magnitude(w, value, signed=signed)
    d, divisor_sign = _magnitude(w, divisor, signed=signed)
    result = _by_magnitude(w, dividend, d)
    quotient, remainder = result.quotient, result.remainder
    differ = w.op(Opcode.XOR, sign, divisor_sign)
    if differ != ZERO:
        inexact = w.negated(w.equal(remainder, _NOTHING))
        step = w.op(Opcode.AND, differ, inexact)
        quotient = w.add(quotient, Pair(step, ZERO))
        remainder = w.select(step, w.sub(d, remainder), remainder)
    whole = _signed(w, quotient, differ) if is_quotient else _signed(w, remainder, divisor_sign)
    low, high = w.range(divisor)
    if low > 0 or high < 0:
        return whole
    return w.select(w.equal(w.pair(divisor), _NOTHING), _NOTHING, whole)


def _by_magnitude(w: Words, dividend: Pair, d: Pair) -> _Division:
    if not _is_constant(d):
        return by_variable(w, dividend, d)
    power = _power_of(d)
    if power is None:
        return by_constant(w, dividend, d)
    rest = w.logic(Opcode.AND, dividend, _constant((1 << power) - 1))
    return _Division(lshr(w, dividend, power, (power, power)), rest)


def _power_of(d: Pair) -> int | None:
    """The exponent of a constant power of two (0 for 0)."""
    assert isinstance(d.low, Const)
    assert isinstance(d.high, Const)
    divisor = d.low.word | d.high.word << WORD_BITS
    return max(divisor.bit_length() - 1, 0) if divisor & (divisor - 1) == 0 else None


def _magnitude(w: Words, operand: Value, *, signed: bool) -> tuple[Pair, Value]:
    """|operand|, and its sign as a word of ones or zeros."""
    pair = w.pair(operand)
    if not signed or w.range(operand)[0] >= 0:
        return pair, ZERO
    sign = w.sign(pair)
    return w.negate_if(pair, sign), sign


def _signed(w: Words, magnitude: Pair, sign: Value) -> Pair:
    return magnitude if sign == ZERO else w.negate_if(magnitude, sign)


def _is_constant(pair: Pair) -> bool:
    return isinstance(pair.low, Const) and isinstance(pair.high, Const)


def _constant(value: int) -> Pair:
    return Pair(Const(value & WORD_MASK), Const(value >> WORD_BITS & WORD_MASK))


def _by_power(w: Words, op: Instr, magnitude: int, *, negative: bool) -> Pair:
    """A shift or a mask, after a bias that lets negative dividends round towards 0."""
    value = w.pair(op.operands[0])
    power = max(magnitude.bit_length() - 1, 0)
    bias = _NOTHING
    if op.op in _SIGNED and w.range(op.operands[0])[0] < 0 and power > 0:
        sign = w.sign(value)
        bias = lshr(w, Pair(sign, sign), _BITS - power, (_BITS - power, _BITS - power))
    biased = w.add(value, bias)
    if op.op not in _QUOTIENTS:
        kept = w.logic(Opcode.AND, biased, _constant(magnitude - 1 ^ _LIMIT - 1))
        return w.sub(value, kept)
    shift = ashr if op.op in _SIGNED else lshr
    quotient = shift(w, biased, power, (power, power))
    return _signed(w, quotient, Const(WORD_MASK) if negative else ZERO)


def by_constant(w: Words, dividend: Pair, d: Pair) -> _Division:
    """The estimate lacks at most 1 for the reciprocal's rounding, and 2 if carries are dropped: for
    small divisors the remainder is a word all the same, and two corrections cost less than carries.
    """
    assert isinstance(d.low, Const)
    assert isinstance(d.high, Const)
    divisor = d.low.word | d.high.word << WORD_BITS
    carries = (2 + _DROPPED_CARRIES) * divisor >= 1 << WORD_BITS
    quotient = _high_product(w, dividend, _constant(_LIMIT // divisor), carries=carries)
    remainder = w.sub(dividend, w.mul(quotient, d))
    if not carries or 2 * divisor < 1 << WORD_BITS:
        remainder = Pair(remainder.low, ZERO)
    result = _Division(quotient, remainder)
    if not carries:
        result = _corrected(w, result, _constant(2 * divisor), 2)
    return _corrected(w, result, d, 1)


def _corrected(w: Words, division: _Division, d: Pair, units: int) -> _Division:
    """Takes `d`, which is `units` divisors, off a remainder that is not below it."""
    below = w.less(division.remainder, d, signed=False)
    more = w.add(division.quotient, _constant(units))
    rest = w.sub(division.remainder, d)
    if division.remainder.high == ZERO:  # then d is a word, too, where anything is taken off
        rest = Pair(rest.low, ZERO)
    return _Division(
        w.select(below, division.quotient, more), w.select(below, division.remainder, rest)
    )


def by_variable(w: Words, dividend: Pair, d: Pair) -> _Division:
    """With R = 2**64 / d, the reciprocal x lies in (R - 2, R], so the quotient lacks at most 2.

    Each step turns x = R (1 - e) into R (1 - e**2), rounded down. The first x has e < 2**-19, or
    is 1 where R < 2: after two steps R e**4 and the last rounding remain, less than 1.1 for R > 16;
    for smaller R the first rounding leaves less than 1 + 2**-15, and no step makes that worse.
    """
    x = _estimate(w, d)
    for _ in range(2):
        error = w.mul(w.sub(_NOTHING, d), x)
        x = w.add(x, _high_product(w, x, error, carries=True))
    quotient = _high_product(w, dividend, x, carries=True)
    result = _Division(quotient, w.sub(dividend, w.mul(quotient, d)))
    return _corrected(w, _corrected(w, result, d, 1), d, 1)


_RECIPROCAL_MAGIC = 0x7EF311C7  # a chord of 1/m in the bits of a float32, to within 5.06 %
_ONE = 0x3F800000
_TWO_32 = 0x4F800000
_SCALE = 0x5F7FFFF0  # 2**64 * (1 - 2**-20): below the reciprocal in spite of all roundings
_STEPS = 3
_TOP_EXPONENT = 127 + _BITS - 1


def _estimate(w: Words, d: Pair) -> Pair:
    """2**64 / d to within 2**-19, rounded down, at least 1."""
    as_float = w.op(Opcode.UITOFP, d.low)
    if d.high != ZERO:
        as_float = w.op(Opcode.FMA, w.op(Opcode.UITOFP, d.high), _TWO_32, as_float)
    minus_d = w.op(Opcode.FNEG, as_float)
    y = w.op(Opcode.SUB, _RECIPROCAL_MAGIC, as_float)
    for _ in range(_STEPS):
        y = w.op(Opcode.FMA, y, w.op(Opcode.FMA, minus_d, y, _ONE), y)
    scaled = w.op(Opcode.FMUL, y, _SCALE)
    # Its mantissa, at the top of two words, is shifted down to where its exponent says.
    mantissa = w.op(Opcode.OR, w.op(Opcode.SHL, scaled, 8), 1 << WORD_BITS - 1)
    by = w.op(Opcode.SUB, _TOP_EXPONENT, w.op(Opcode.LSHR, scaled, 23))
    by = w.op(Opcode.SMIN, by, _BITS - 1)
    return lshr(w, Pair(ZERO, mantissa), by, (0, _BITS - 1))


def _high_product(w: Words, a: Pair, b: Pair, *, carries: bool) -> Pair:
    """The upper 64 bits of a * b; without `carries` it can lack up to 2."""
    total = w.product(a.high, b.high)
    crosses = [w.product(a.high, b.low), w.product(a.low, b.high)]
    middle = w.op(Opcode.MULHU, a.low, b.low) if carries else ZERO
    for cross in crosses:
        total = w.add(total, Pair(cross.high, ZERO))
        if carries:
            summed = w.add(Pair(middle, ZERO), Pair(cross.low, ZERO))
            middle = summed.low
            total = w.add(total, Pair(summed.high, ZERO))
    return total
