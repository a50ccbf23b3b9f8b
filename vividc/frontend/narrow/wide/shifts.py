"""Shifts of two words, by constant and by variable amounts.

The machine's amounts count modulo 32. `(x >> 1) >> (31 - n)` is x >> (32 - n) for n from 0 to 31,
and gives 0 for n = 0 where the shift by 32 would give x.
"""

from __future__ import annotations

from vividc.frontend.narrow.wide.words import ZERO, Pair, Words
from vividc.frontend.ranges.interval import Interval
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS
from vividc.ssa.ir import Const, Value

_LAST = WORD_BITS - 1
_BITS = 64


def shl(w: Words, a: Pair, by: Value | int, bounds: Interval) -> Pair:
    """a << by; `bounds`: amounts there can be. Amounts count modulo 64, as x86 does it."""
    if isinstance(by, int) or bounds[0] == bounds[1]:
        return _shl_constant(w, a, by if isinstance(by, int) else bounds[0] % _BITS)
    low = w.op(Opcode.SHL, a.low, by)
    near = Pair(low, _joined_up(w, a.high, a.low, by))
    far = Pair(ZERO, low)
    return _near_or_far(w, by, bounds, near, far)


def lshr(w: Words, a: Pair, by: Value | int, bounds: Interval) -> Pair:
    """a >> by, zeros shifted in."""
    return _right(w, a, by, bounds, Opcode.LSHR)


def ashr(w: Words, a: Pair, by: Value | int, bounds: Interval) -> Pair:
    """a >> by, the sign shifted in."""
    return _right(w, a, by, bounds, Opcode.ASHR)


def _right(w: Words, a: Pair, by: Value | int, bounds: Interval, opcode: Opcode) -> Pair:
    fill = w.sign(a) if opcode is Opcode.ASHR else ZERO
    if isinstance(by, int) or bounds[0] == bounds[1]:
        return _right_constant(w, a, by if isinstance(by, int) else bounds[0] % _BITS, opcode, fill)
    high = w.op(opcode, a.high, by)
    near = Pair(_joined_down(w, a.high, a.low, by), high)
    return _near_or_far(w, by, bounds, near, Pair(high, fill))


def _shl_constant(w: Words, a: Pair, by: int) -> Pair:
    if by == 0:
        return a
    if by >= WORD_BITS:
        return Pair(ZERO, w.op(Opcode.SHL, a.low, by - WORD_BITS))
    carried = w.op(Opcode.LSHR, a.low, WORD_BITS - by)
    high = w.op(Opcode.OR, w.op(Opcode.SHL, a.high, by), carried)
    return Pair(w.op(Opcode.SHL, a.low, by), high)


def _right_constant(w: Words, a: Pair, by: int, opcode: Opcode, fill: Value) -> Pair:
    if by == 0:
        return a
    if by >= WORD_BITS:
        return Pair(w.op(opcode, a.high, by - WORD_BITS), fill)
    carried = w.op(Opcode.SHL, a.high, WORD_BITS - by)
    low = w.op(Opcode.OR, w.op(Opcode.LSHR, a.low, by), carried)
    return Pair(low, w.op(opcode, a.high, by))


def _near_or_far(w: Words, by: Value, bounds: Interval, near: Pair, far: Pair) -> Pair:
    """`near` for amounts below 32, `far` from 32 on."""
    low, high = bounds
    if low >= 0 and high < WORD_BITS:
        return near
    if low >= WORD_BITS and high < _BITS:
        return far
    if low >= 0 and high < _BITS:
        return w.select(w.op(Opcode.ICMP_ULT, by, WORD_BITS), near, far)
    return w.select(_is_far(w, by), far, near)


def _is_far(w: Words, by: Value) -> Value:
    """Bit 5 of an amount."""
    return w.op(Opcode.ICMP_SLT, w.op(Opcode.SHL, by, _LAST - 5), ZERO)


def _joined_up(w: Words, high: Value, low: Value, by: Value) -> Value:
    """The high word of high:low << by, by modulo 32."""
    rest = w.op(Opcode.XOR, by, _LAST)
    carried = w.op(Opcode.LSHR, w.op(Opcode.LSHR, low, 1), rest)
    return w.op(Opcode.OR, w.op(Opcode.SHL, high, by), carried)


def _joined_down(w: Words, high: Value, low: Value, by: Value) -> Value:
    """The low word of high:low >> by, by modulo 32."""
    rest = w.op(Opcode.XOR, by, _LAST)
    carried = w.op(Opcode.SHL, w.op(Opcode.SHL, high, 1), rest)
    return w.op(Opcode.OR, w.op(Opcode.LSHR, low, by), carried)


def funnel_left(w: Words, high: Pair, low: Pair, by: Value | int) -> Pair:
    """The upper 64 bits of (high:low) << by, amounts modulo 64; a rotation where both are equal."""
    far = Const(int(by >= WORD_BITS)) if isinstance(by, int) else _is_far(w, by)
    top = w.choose(far, high.low, high.high)
    middle = w.choose(far, low.high, high.low)
    bottom = w.choose(far, low.low, low.high)
    amount = Const(by % WORD_BITS) if isinstance(by, int) else by
    return Pair(_joined_up(w, middle, bottom, amount), _joined_up(w, top, middle, amount))


def funnel_right(w: Words, high: Pair, low: Pair, by: Value | int) -> Pair:
    """The lower 64 bits of (high:low) >> by, amounts modulo 64."""
    far = Const(int(by >= WORD_BITS)) if isinstance(by, int) else _is_far(w, by)
    bottom = w.choose(far, low.high, low.low)
    middle = w.choose(far, high.low, low.high)
    top = w.choose(far, high.high, high.low)
    amount = Const(by % WORD_BITS) if isinstance(by, int) else by
    return Pair(_joined_down(w, middle, bottom, amount), _joined_down(w, top, middle, amount))
