"""64-bit integers to float32, rounded once."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.frontend.narrow.wide.words import ZERO, Pair, Words
from vividc.frontend.ranges.interval import S32, contains
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Instr, Ref, Value

_SIGN = 0x80000000
_TWO_24 = 0x4B800000  # as a float32, like the next
_EXACT = 24  # integers up to 2**24 are float32
_EXPONENT_SHIFT = 23
_BIAS = 127
_NEAR = 60
"""Integers so near to 2**31 on either side are 2**31 as float32, and those near -2**31 are that."""

_DEPTH = 4


def to_float(w: Words, op: Instr) -> Value:
    """sitofp, uitofp: correctly rounded to nearest even (a double runs in float32)."""
    [operand] = op.operands
    low, high = w.range(operand)
    if op.type == "double":
        w.emitter.demote(op)
    signed = op.op == "sitofp"
    moved = _moved_word(w, operand) if signed else None
    if moved is not None:
        return w.op(Opcode.SITOFP, moved)
    value = w.pair(operand)
    if max(-low, high) <= 1 << 2 * _EXACT and (signed or low >= 0):
        return _of_48_bits(w, value)
    if not signed or low >= 0:
        return _of_magnitude(w, value)
    sign = w.sign(value)
    magnitude = _of_magnitude(w, w.negate_if(value, sign))
    return w.op(Opcode.OR, magnitude, w.op(Opcode.AND, sign, _SIGN))


def _moved_word(w: Words, operand: Value) -> Value | None:
    """A word that is the same float as a sum of a word and small numbers: the word, where that
    would take the sum past all words, is one that does not. None: it is no such sum.
    """
    terms = list(_terms(w, operand, 1, _DEPTH))
    if not w.emitter.signed(*(term for _, term in terms)):
        return None
    far = [term for term in terms if not contains((-_NEAR, _NEAR), w.range(term[1]))]
    if len(far) != 1 or far[0][0] < 0 or len(terms) == 1:
        return None
    [(_, first)] = far
    step: Value = ZERO
    least = most = 0
    for sign, term in terms:
        if term is not first:
            ends = [sign * end for end in w.range(term)]
            least, most = least + min(ends), most + max(ends)
            step = w.op(Opcode.ADD if sign > 0 else Opcode.SUB, step, w.emitter.value(term))
    least, most = min(least, 0), max(most, 0)
    if most - least > _NEAR:
        return None
    low, high = w.range(first)
    word = w.emitter.value(first)
    if high > S32[1] - most:
        word = w.op(Opcode.SMIN, word, S32[1] - most)
    if low < S32[0] - least:
        word = w.op(Opcode.SMAX, word, S32[0] - least)
    return w.op(Opcode.ADD, word, step)


def _terms(w: Words, operand: Value, sign: int, depth: int) -> Iterator[tuple[int, Value]]:
    """The terms of a sum that one word may not hold, with their signs."""
    made = w.emitter.function.definitions.get(operand.id) if isinstance(operand, Ref) else None
    is_sum = isinstance(made, Instr) and made.op in ("add", "sub") and depth
    if not is_sum or w.emitter.signed(operand):
        yield sign, operand
        return
    assert isinstance(made, Instr)
    first, second = made.operands
    yield from _terms(w, first, sign, depth - 1)
    yield from _terms(w, second, -sign if made.op == "sub" else sign, depth - 1)


def _of_48_bits(w: Words, value: Pair) -> Value:
    """Two exact floats, and one FMA that rounds their sum."""
    top = w.op(Opcode.SHL, value.high, WORD_BITS - _EXACT)
    top = w.op(Opcode.OR, top, w.op(Opcode.LSHR, value.low, _EXACT))
    rest = w.op(Opcode.AND, value.low, (1 << _EXACT) - 1)
    upper, lower = w.op(Opcode.SITOFP, top), w.op(Opcode.SITOFP, rest)
    return w.op(Opcode.FMA, upper, _TWO_24, lower)


def _of_magnitude(w: Words, value: Pair) -> Value:
    """The upper 32 bits from the first 1 on, the last of them set if any below is (von Neumann's
    rounding to odd): converting that word rounds as the whole integer would, and the scale is a
    power of two.
    """
    low, high = value
    # Without the bit below its first 1 no word rounds up to the next power of two.
    first = w.op(Opcode.AND, high, w.op(Opcode.XOR, w.op(Opcode.LSHR, high, 1), WORD_MASK))
    exponent = w.op(Opcode.LSHR, w.op(Opcode.UITOFP, first), _EXPONENT_SHIFT)
    zeros = w.op(Opcode.SUB, _BIAS + WORD_BITS - 1, exponent)
    rest = w.op(Opcode.XOR, zeros, WORD_BITS - 1)
    carried = w.op(Opcode.LSHR, w.op(Opcode.LSHR, low, 1), rest)
    top = w.op(Opcode.OR, w.op(Opcode.SHL, high, zeros), carried)
    lost = w.op(Opcode.ICMP_NE, w.op(Opcode.SHL, low, zeros), ZERO)
    word = w.op(Opcode.UITOFP, w.op(Opcode.OR, top, lost))
    scale = w.op(Opcode.SUB, _BIAS + WORD_BITS, zeros)
    scaled = w.op(Opcode.FMUL, word, w.op(Opcode.SHL, scale, _EXPONENT_SHIFT))
    small = w.op(Opcode.ICMP_EQ, high, ZERO)
    return w.choose(small, w.op(Opcode.UITOFP, low), scaled)
