"""Integer instructions in words of 32 bits."""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import KernelError
from vividc.frontend.narrow.divide import divide
from vividc.frontend.narrow.emit import WORD_HINT, Emitter
from vividc.frontend.narrow.floor_division import FLOOR_DIVISIONS
from vividc.frontend.narrow.small import emit_masked, sign_extended
from vividc.frontend.ranges.interval import width
from vividc.lang.operations import MULHS, MULHU
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_BITS
from vividc.ssa.ir import Const, Instr, Int, Value

Rule = Callable[[Emitter, Instr], None]

_HINT = WORD_HINT
_SIGNED: dict[str, tuple[Opcode, bool]] = {
    "eq": (Opcode.ICMP_EQ, False),
    "ne": (Opcode.ICMP_NE, False),
    "slt": (Opcode.ICMP_SLT, False),
    "sle": (Opcode.ICMP_SLE, False),
    "sgt": (Opcode.ICMP_SLT, True),
    "sge": (Opcode.ICMP_SLE, True),
    "ult": (Opcode.ICMP_ULT, False),
    "ule": (Opcode.ICMP_ULE, False),
    "ugt": (Opcode.ICMP_ULT, True),
    "uge": (Opcode.ICMP_ULE, True),
}


def computes(op: Instr) -> bool:
    """Whether a conversion is more than another name for its operand's word."""
    if op.op == "trunc":
        return width(op.type) < WORD_BITS
    if op.op == "sext":
        return width(op.source) < WORD_BITS
    return False


def _ring(opcode: Opcode) -> Rule:
    """The low word of the result depends on the low words of the operands only."""

    def rule(emitter: Emitter, op: Instr) -> None:
        operands = tuple(emitter.value(arg) for arg in op.operands)
        bits = width(op.type)
        if bits >= WORD_BITS or opcode in (Opcode.AND, Opcode.OR, Opcode.XOR):
            emitter.emit(op, opcode, operands)
        else:
            wide = emitter.helper(op, opcode, *operands)
            emitter.emit(op, Opcode.AND, (wide, Const((1 << bits) - 1)))

    return rule


def _truncate(emitter: Emitter, op: Instr) -> None:
    mask = Const((1 << width(op.type)) - 1)
    emitter.emit(op, Opcode.AND, (emitter.value(op.operands[0]), mask))


def _sign_extend(emitter: Emitter, op: Instr) -> None:
    """From less than a word: its upper bits are 0 in our representation."""
    bits = width(op.source)
    word = emitter.value(op.operands[0])
    if bits == 1:
        emit_masked(emitter, op, Opcode.SUB, Const(0), word)
        return
    up = emitter.helper(op, Opcode.SHL, word, Const(WORD_BITS - bits))
    emit_masked(emitter, op, Opcode.ASHR, up, Const(WORD_BITS - bits))


def _small(op: Instr) -> bool:
    return width(op.type) < WORD_BITS


def _whole(emitter: Emitter, op: Instr, *operands: Value, what: str) -> bool:
    """Whether the operands' words are to be read as signed (else as unsigned); refuses if neither
    is right.
    """
    if emitter.signed(*operands):
        return True
    if width(op.type) == WORD_BITS or emitter.unsigned(*operands):
        return False
    for operand in operands:
        emitter.require_signed(operand, op.loc, what, _HINT)
    raise KernelError(f"{what} mixes negative and large unsigned integers", loc=op.loc, hint=_HINT)


def _compare(emitter: Emitter, op: Instr) -> None:
    pred = op.pred
    if not _small(op):
        pred = _word_predicate(emitter, op)
    opcode, swap = _SIGNED[pred]
    left, right = _extended(emitter, op, op.operands, is_signed=op.pred[0] == "s")
    emitter.emit(op, opcode, (right, left) if swap else (left, right))


def _extended(
    emitter: Emitter, op: Instr, operands: tuple[Value, ...], *, is_signed: bool
) -> tuple[Value, ...]:
    """The operands' words, those of less than a word as signed or unsigned."""
    if not is_signed:
        return tuple(emitter.value(operand) for operand in operands)
    return tuple(sign_extended(emitter, op, operand, width(op.type)) for operand in operands)


def _word_predicate(emitter: Emitter, op: Instr) -> str:
    """The same comparison of words. Signed where both agree: the controller counts such loops."""
    pred = op.pred
    if pred in ("eq", "ne"):
        if width(op.type) > WORD_BITS:
            _whole(emitter, op, *op.operands, what="the compared integer")
        return pred
    nonnegative = all(emitter.range(arg)[0] >= 0 for arg in op.operands)
    if width(op.type) == WORD_BITS:
        return "s" + pred[1:] if nonnegative else pred
    if _whole(emitter, op, *op.operands, what="the compared integer"):
        # Sign extension keeps the unsigned order too.
        return "s" + pred[1:] if nonnegative else pred
    return "u" + pred[1:]


def _shift_left(emitter: Emitter, op: Instr) -> None:
    if _small(op):
        emit_masked(emitter, op, Opcode.SHL, *(emitter.value(arg) for arg in op.operands))
        return
    value, amount = op.operands
    _emit_shift(emitter, op, Opcode.SHL, emitter.value(value), amount, outside=Const(0))


def _shift_right(emitter: Emitter, op: Instr) -> None:
    """Logical or arithmetic; a value of 64 bits must be its word's extension, and its sign decides
    which.
    """
    if _small(op):
        _shift_right_small(emitter, op)
        return
    value, amount = op.operands
    word = emitter.value(value)
    if width(op.type) == WORD_BITS:
        opcode = Opcode.ASHR if op.op == "ashr" else Opcode.LSHR
        emitter.emit(op, opcode, (word, emitter.value(amount)))
        return
    if isinstance(amount, Int) and emitter.demand(op) + amount.value <= WORD_BITS:
        # What comes in from above the word is not looked at.
        emitter.emit(op, Opcode.LSHR, (word, Const(amount.value)))
        return
    if not _whole(emitter, op, value, what="the shifted integer"):
        _emit_shift(emitter, op, Opcode.LSHR, word, amount, outside=Const(0))
    elif op.op == "lshr" and emitter.range(value)[0] < 0:
        _shift_sign_down(emitter, op, word, amount)
    else:
        outside = (
            emitter.helper(op, Opcode.ASHR, word, Const(WORD_BITS - 1))
            if _may_exceed(emitter, amount)
            else Const(0)
        )
        _emit_shift(emitter, op, Opcode.ASHR, word, amount, outside=outside)


def _shift_sign_down(emitter: Emitter, op: Instr, word: Value, amount: Value) -> None:
    """lshr i64 of a negative value: below 32 the result's low word is that of ashr, from 32 on the
    sign's.
    """
    if not isinstance(amount, Int):
        raise KernelError("a shift of a negative integer as unsigned", loc=op.loc, hint=_HINT)
    if amount.value < WORD_BITS:
        emitter.emit(op, Opcode.ASHR, (word, Const(amount.value)))
        return
    sign = emitter.helper(op, Opcode.ASHR, word, Const(WORD_BITS - 1))
    emitter.emit(op, Opcode.LSHR, (sign, Const(amount.value - WORD_BITS)))


def _may_exceed(emitter: Emitter, amount: Value) -> bool:
    low, high = emitter.range(amount)
    return low < 0 or high >= WORD_BITS


def _emit_shift(
    emitter: Emitter, op: Instr, opcode: Opcode, word: Value, amount: Value, outside: Value
) -> None:
    """The machine's amounts count modulo 32; LLVM's go up to the width of the type."""
    if width(op.type) == WORD_BITS or not _may_exceed(emitter, amount):
        emitter.emit(op, opcode, (word, emitter.value(amount)))
        return
    by = emitter.value(amount)
    inside = emitter.helper(op, Opcode.ICMP_ULT, by, Const(WORD_BITS), type_=Type.PRED)
    shifted = emitter.helper(op, opcode, word, by)
    emitter.emit(op, Opcode.SELECT, (inside, shifted, outside))


def _shift_right_small(emitter: Emitter, op: Instr) -> None:
    """LLVM gives amounts from the type's width on no meaning."""
    value, amount = op.operands
    if op.op == "lshr":
        emitter.emit(op, Opcode.LSHR, (emitter.value(value), emitter.value(amount)))
        return
    word = sign_extended(emitter, op, value, width(op.type))
    emit_masked(emitter, op, Opcode.ASHR, word, emitter.value(amount))


def _divide(emitter: Emitter, op: Instr) -> None:
    divide(emitter, op, _HINT)


def _extremum(signed: bool, largest: bool) -> Rule:
    def rule(emitter: Emitter, op: Instr) -> None:
        if _small(op):
            # Unsigned ones are positive words.
            words = _extended(emitter, op, op.operands[:2], is_signed=signed)
            emit_masked(emitter, op, Opcode.SMAX if largest else Opcode.SMIN, *words)
            return
        left, right = (emitter.value(arg) for arg in op.operands[:2])
        as_signed = signed
        if width(op.type) > WORD_BITS:
            whole = _whole(emitter, op, *op.operands[:2], what="the compared integer")
            as_signed = signed and whole
        if as_signed:
            emitter.emit(op, Opcode.SMAX if largest else Opcode.SMIN, (left, right))
            return
        less = emitter.helper(op, Opcode.ICMP_ULT, left, right, type_=Type.PRED)
        emitter.emit(op, Opcode.SELECT, (less, right, left) if largest else (less, left, right))

    return rule


def _abs(emitter: Emitter, op: Instr) -> None:
    value = op.operands[0]
    if width(op.type) > WORD_BITS and not emitter.signed(value):
        emitter.require_signed(value, op.loc, "the operand of abs", _HINT)
    word = sign_extended(emitter, op, value, width(op.type))
    negated = emitter.helper(op, Opcode.SUB, Const(0), word)
    emit_masked(emitter, op, Opcode.SMAX, word, negated)


def _three_way(signed: bool) -> Rule:
    """scmp, ucmp: (a > b) - (a < b)."""

    def rule(emitter: Emitter, op: Instr) -> None:
        source = emitter.type_of(op.operands[0]) or emitter.type_of(op.operands[1])
        bits = width(source)
        left, right = (
            sign_extended(emitter, op, arg, bits) if signed else emitter.value(arg)
            for arg in op.operands[:2]
        )
        as_signed = signed
        if bits > WORD_BITS:
            if not emitter.signed(*op.operands[:2]) and not emitter.unsigned(*op.operands[:2]):
                raise KernelError(
                    "a three-way comparison of 64-bit integers", loc=op.loc, hint=_HINT
                )
            # Zero extensions are ordered as words are; sign extensions keep the unsigned order.
            as_signed = signed and emitter.signed(*op.operands[:2])
        less = Opcode.ICMP_SLT if as_signed else Opcode.ICMP_ULT
        above = emitter.helper(op, less, right, left, type_=Type.PRED)
        below = emitter.helper(op, less, left, right, type_=Type.PRED)
        emit_masked(emitter, op, Opcode.SUB, above, below)

    return rule


def _high_product(opcode: Opcode) -> Rule:
    def rule(emitter: Emitter, op: Instr) -> None:
        emitter.emit(op, opcode, tuple(emitter.value(arg) for arg in op.operands))

    return rule


RULES: dict[str, Rule] = {
    "add": _ring(Opcode.ADD),
    "sub": _ring(Opcode.SUB),
    "mul": _ring(Opcode.MUL),
    "and": _ring(Opcode.AND),
    "or": _ring(Opcode.OR),
    "xor": _ring(Opcode.XOR),
    "shl": _shift_left,
    "lshr": _shift_right,
    "ashr": _shift_right,
    "icmp": _compare,
    "trunc": _truncate,
    "sext": _sign_extend,
    "sdiv": _divide,
    "udiv": _divide,
    "srem": _divide,
    "urem": _divide,
    **dict.fromkeys(FLOOR_DIVISIONS, _divide),
}
CALLS: dict[str, Rule] = {
    "smin": _extremum(signed=True, largest=False),
    "smax": _extremum(signed=True, largest=True),
    "umin": _extremum(signed=False, largest=False),
    "umax": _extremum(signed=False, largest=True),
    "abs": _abs,
    "scmp": _three_way(signed=True),
    "ucmp": _three_way(signed=False),
    MULHS: _high_product(Opcode.MULHS),
    MULHU: _high_product(Opcode.MULHU),
}
