"""Integers of less than a word: their words have zeros above, so signed operations extend first."""

from __future__ import annotations

from vividc.frontend.narrow.emit import Emitter
from vividc.frontend.ranges.interval import Interval, as_signed, width
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Const, Instr, Int, Kind, Value


def is_small(type_: Kind) -> bool:
    """Whether an integer type has less bits than a word."""
    return width(type_) < WORD_BITS


def sign_extended(emitter: Emitter, op: Instr, operand: Value, bits: int) -> Value:
    """The word of an operand of `bits` bits, read as signed; free where it is not negative."""
    if bits >= WORD_BITS:
        return emitter.value(operand)
    if isinstance(operand, Int):
        return Const(signed_range((operand.value, operand.value), bits)[0] & WORD_MASK)
    word = emitter.value(operand)
    if bits == 1:
        return emitter.helper(op, Opcode.SUB, Const(0), word)
    if emitter.range(operand)[1] < 1 << (bits - 1):
        return word
    up = emitter.helper(op, Opcode.SHL, word, Const(WORD_BITS - bits))
    return emitter.helper(op, Opcode.ASHR, up, Const(WORD_BITS - bits))


def signed_range(interval: Interval, bits: int) -> Interval:
    """The values of an integer of `bits` bits, read as signed."""
    return as_signed(interval, bits)


def emit_masked(emitter: Emitter, op: Instr, opcode: Opcode, *operands: Value) -> None:
    """The instruction for `op`, and zeros above its bits."""
    bits = width(op.type)
    if bits >= WORD_BITS:
        emitter.emit(op, opcode, operands)
        return
    wide = emitter.helper(op, opcode, *operands)
    emitter.emit(op, Opcode.AND, (wide, Const((1 << bits) - 1)))
