"""Bit counts, permutations, rotations and saturating sums of integers of any width up to a word,
and of 64-bit ones that a word determines.
"""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import KernelError
from vividc.frontend.advice import Advice
from vividc.frontend.narrow.emit import WORD_HINT, Emitter
from vividc.frontend.narrow.small import emit_masked, sign_extended
from vividc.frontend.ranges.interval import width
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Const, Instr, Int, Value

Rule = Callable[[Emitter, Instr], None]
_UINT32 = Advice("use np.uint32(...)", c="use uint32_t")
_INT_MAX = 0x7FFFFFFF


def _count_ones(emitter: Emitter, op: Instr) -> None:
    word = _word(emitter, op)
    if width(op.type) <= WORD_BITS or emitter.range(op.operands[0])[0] >= 0:
        emitter.emit(op, Opcode.CTPOP, (word,))
        return
    ones = emitter.helper(op, Opcode.CTPOP, word)
    sign = emitter.helper(op, Opcode.ASHR, word, Const(WORD_BITS - 1))
    above = emitter.helper(op, Opcode.AND, sign, Const(WORD_BITS))
    emitter.emit(op, Opcode.ADD, (ones, above))


def _leading_zeros(emitter: Emitter, op: Instr) -> None:
    """A word has 32 - width more; the upper word of a 64-bit value is 0, or all ones."""
    bits = width(op.type)
    word = _word(emitter, op)
    if bits == WORD_BITS:
        emitter.emit(op, Opcode.CTLZ, (word,))
        return
    zeros = emitter.helper(op, Opcode.CTLZ, word)
    difference = Const(bits - WORD_BITS & WORD_MASK)
    if bits < WORD_BITS or emitter.range(op.operands[0])[0] >= 0:
        emitter.emit(op, Opcode.ADD, (zeros, difference))
        return
    total = emitter.helper(op, Opcode.ADD, zeros, difference)
    negative = emitter.helper(op, Opcode.ICMP_SLT, word, Const(0), type_=Type.PRED)
    emitter.emit(op, Opcode.SELECT, (negative, Const(0), total))


def _trailing_zeros(emitter: Emitter, op: Instr) -> None:
    """0 has as many as its type has bits, unless LLVM gives it no meaning."""
    bits = width(op.type)
    word = _word(emitter, op)
    if bits < WORD_BITS:
        word = emitter.helper(op, Opcode.OR, word, Const(1 << bits))
    if bits <= WORD_BITS or op.operands[1] == Int(1):
        emitter.emit(op, Opcode.CTTZ, (word,))
        return
    zeros = emitter.helper(op, Opcode.CTTZ, word)
    exists = emitter.helper(op, Opcode.ICMP_NE, word, Const(0), type_=Type.PRED)
    emitter.emit(op, Opcode.SELECT, (exists, zeros, Const(bits)))


def _word(emitter: Emitter, op: Instr) -> Value:
    """The word of the operand, which determines it."""
    operand = op.operands[0]
    if width(op.type) > WORD_BITS and not emitter.unsigned(operand):
        emitter.require_signed(operand, op.loc, "the operand of a bit count", WORD_HINT)
    return emitter.value(operand)


def _permutation(opcode: Opcode) -> Rule:
    """The bits of a smaller type end up at the top of the word."""

    def rule(emitter: Emitter, op: Instr) -> None:
        bits = width(op.type)
        if bits > WORD_BITS:
            raise KernelError("the bits of a 64-bit integer", loc=op.loc, hint=_UINT32)
        word = emitter.value(op.operands[0])
        if bits == WORD_BITS:
            emitter.emit(op, opcode, (word,))
            return
        top = emitter.helper(op, opcode, word)
        emitter.emit(op, Opcode.LSHR, (top, Const(WORD_BITS - bits)))

    return rule


def _funnel(left: bool) -> Rule:
    """fshl, fshr: shifts of two integers side by side, by an amount modulo their width."""

    def rule(emitter: Emitter, op: Instr) -> None:
        bits = width(op.type)
        if bits > WORD_BITS:
            raise KernelError("a rotation of a 64-bit integer", loc=op.loc, hint=_UINT32)
        if bits < WORD_BITS:
            _funnel_small(emitter, op, left)
        elif isinstance(op.operands[2], Int):
            _funnel_constant(emitter, op, op.operands[2].value % bits, left)
        elif op.operands[0] == op.operands[1]:
            _rotate(emitter, op, left)
        else:
            _funnel_variable(emitter, op, left)

    return rule


def _funnel_constant(emitter: Emitter, op: Instr, amount: int, left: bool) -> None:
    high, low = (emitter.value(arg) for arg in op.operands[:2])
    by = amount if left else -amount % WORD_BITS
    if by == 0:
        emitter.emit(op, Opcode.MOV, (high if left else low,))
        return
    up = emitter.helper(op, Opcode.SHL, high, Const(by))
    down = emitter.helper(op, Opcode.LSHR, low, Const(WORD_BITS - by))
    emitter.emit(op, Opcode.OR, (up, down))


def _rotate(emitter: Emitter, op: Instr, left: bool) -> None:
    """The machine's amounts count modulo 32, so that -amount does for 32 - amount."""
    word, amount = emitter.value(op.operands[0]), emitter.value(op.operands[2])
    back = emitter.helper(op, Opcode.SUB, Const(0), amount)
    first, second = (Opcode.SHL, Opcode.LSHR) if left else (Opcode.LSHR, Opcode.SHL)
    one = emitter.helper(op, first, word, amount)
    other = emitter.helper(op, second, word, back)
    emitter.emit(op, Opcode.OR, (one, other))


def _funnel_variable(emitter: Emitter, op: Instr, left: bool) -> None:
    """By one, then by 31 - amount: a shift by 32 would be one by 0."""
    high, low, amount = (emitter.value(arg) for arg in op.operands)
    rest = emitter.helper(op, Opcode.XOR, amount, Const(WORD_BITS - 1))
    if left:
        near = emitter.helper(op, Opcode.SHL, high, amount)
        far = emitter.helper(op, Opcode.LSHR, low, Const(1))
        far = emitter.helper(op, Opcode.LSHR, far, rest)
    else:
        near = emitter.helper(op, Opcode.LSHR, low, amount)
        far = emitter.helper(op, Opcode.SHL, high, Const(1))
        far = emitter.helper(op, Opcode.SHL, far, rest)
    emitter.emit(op, Opcode.OR, (near, far))


def _funnel_small(emitter: Emitter, op: Instr, left: bool) -> None:
    """Both halves side by side in one word; the types that LLVM makes have 8 or 16 bits."""
    bits = width(op.type)
    if 2 * bits > WORD_BITS or bits & (bits - 1):
        raise KernelError(f"a rotation of {op.type}", loc=op.loc, hint=_UINT32)
    high, low, amount = (emitter.value(arg) for arg in op.operands)
    up = emitter.helper(op, Opcode.SHL, high, Const(bits))
    both = emitter.helper(op, Opcode.OR, up, low)
    by = emitter.helper(op, Opcode.AND, amount, Const(bits - 1))
    if left:
        shifted = emitter.helper(op, Opcode.SHL, both, by)
        emit_masked(emitter, op, Opcode.LSHR, shifted, Const(bits))
    else:
        emit_masked(emitter, op, Opcode.LSHR, both, by)


def _saturating(opcode: Opcode, is_signed: bool) -> Rule:
    """Sums and differences that stop at the ends of their type."""

    def rule(emitter: Emitter, op: Instr) -> None:
        bits = width(op.type)
        if bits > WORD_BITS:
            _saturating_wide(emitter, op, opcode, is_signed)
        elif bits < WORD_BITS:
            _saturating_small(emitter, op, opcode, is_signed)
        elif is_signed:
            _saturating_signed(emitter, op, opcode)
        else:
            _saturating_unsigned(emitter, op, opcode)

    return rule


def _saturating_wide(emitter: Emitter, op: Instr, opcode: Opcode, is_signed: bool) -> None:
    """Only unsigned differences of words: all else may need more than a word."""
    if is_signed or opcode is Opcode.ADD:
        raise KernelError("a saturating sum of 64-bit integers", loc=op.loc, hint=WORD_HINT)
    if not emitter.unsigned(*op.operands):
        emitter.require_signed(op.operands[0], op.loc, "the operand of a subtraction", WORD_HINT)
        raise KernelError(
            "a saturating subtraction of negative integers", loc=op.loc, hint=WORD_HINT
        )
    _saturating_unsigned(emitter, op, opcode)


def _saturating_small(emitter: Emitter, op: Instr, opcode: Opcode, is_signed: bool) -> None:
    bits = width(op.type)
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)
    if is_signed:
        left, right = (sign_extended(emitter, op, arg, bits) for arg in op.operands)
    else:
        left, right = (emitter.value(arg) for arg in op.operands)
    exact = emitter.helper(op, opcode, left, right)
    above = emitter.helper(op, Opcode.SMAX, exact, Const(low & WORD_MASK))
    emit_masked(emitter, op, Opcode.SMIN, above, Const(high))


def _saturating_unsigned(emitter: Emitter, op: Instr, opcode: Opcode) -> None:
    left, right = (emitter.value(arg) for arg in op.operands)
    result = emitter.helper(op, opcode, left, right)
    if opcode is Opcode.ADD:
        wraps = emitter.helper(op, Opcode.ICMP_ULT, result, left, type_=Type.PRED)
    else:
        wraps = emitter.helper(op, Opcode.ICMP_ULT, left, right, type_=Type.PRED)
    limit = Const(WORD_MASK if opcode is Opcode.ADD else 0)
    emitter.emit(op, Opcode.SELECT, (wraps, limit, result))


def _saturating_signed(emitter: Emitter, op: Instr, opcode: Opcode) -> None:
    """The result wrapped if its sign is wrong: not the left operand's, though it must be."""
    left, right = (emitter.value(arg) for arg in op.operands)
    result = emitter.helper(op, opcode, left, right)
    changed = emitter.helper(op, Opcode.XOR, result, left)
    other = result if opcode is Opcode.ADD else left
    differs = emitter.helper(op, Opcode.XOR, other, right)
    both = emitter.helper(op, Opcode.AND, changed, differs)
    wraps = emitter.helper(op, Opcode.ICMP_SLT, both, Const(0), type_=Type.PRED)
    sign = emitter.helper(op, Opcode.ASHR, left, Const(WORD_BITS - 1))
    limit = emitter.helper(op, Opcode.XOR, sign, Const(_INT_MAX))
    emitter.emit(op, Opcode.SELECT, (wraps, limit, result))


CALLS: dict[str, Rule] = {
    "ctpop": _count_ones,
    "ctlz": _leading_zeros,
    "cttz": _trailing_zeros,
    "bswap": _permutation(Opcode.BSWAP),
    "bitreverse": _permutation(Opcode.BITREVERSE),
    "fshl": _funnel(left=True),
    "fshr": _funnel(left=False),
    "uadd.sat": _saturating(Opcode.ADD, is_signed=False),
    "usub.sat": _saturating(Opcode.SUB, is_signed=False),
    "sadd.sat": _saturating(Opcode.ADD, is_signed=True),
    "ssub.sat": _saturating(Opcode.SUB, is_signed=True),
}
