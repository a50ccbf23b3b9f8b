"""Comparisons, extrema and shifts of 64-bit integers that outgrow a word: in two words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from vividc.dfg.cfg import Const, Instr, Phi, Ref, Value
from vividc.dfg.opcodes import Opcode, Type
from vividc.errors import KernelError
from vividc.frontend.emit import Emitter
from vividc.frontend.ssa import Int, Local, Op, Operand, WidePhi

_MASK = 0xFFFFFFFF
_WORD = 32
_SIGN_SHIFT = Const(31)
WORD_HINT = (
    "wrap the result in np.int32(...), or bound it with a comparison before; "
    "a range with a step: range(0, min(n, len(x)), 2)"
)
_DEPTH = 4
"""Sums deeper than this are refused: each level costs two or three operations."""


class _Pair(NamedTuple):
    """A 64-bit integer: its words."""

    low: Value
    high: Value


def compare_wide(emitter: Emitter, op: Op) -> bool:
    """Emits the comparison `op` in two words; False where an operand is no sum of words."""
    pairs = [_pair(emitter, op, operand, _DEPTH) for operand in op.args]
    left, right = pairs
    if left is None or right is None:
        return False
    if op.pred in ("eq", "ne"):
        same = Opcode.ICMP_EQ if op.pred == "eq" else Opcode.ICMP_NE
        lows = emitter.helper(op, same, left.low, right.low, type_=Type.PRED)
        highs = emitter.helper(op, same, left.high, right.high, type_=Type.PRED)
        emitter.emit(op, Opcode.AND if op.pred == "eq" else Opcode.OR, (lows, highs))
        return True
    if op.pred[1] == "g":
        left, right = right, left
    is_signed, or_equal = op.pred[0] == "s", op.pred[2] == "e"
    emitter.emit(op, Opcode.OR, _less(emitter, op, left, right, is_signed, or_equal=or_equal))
    return True


def extremum_wide(emitter: Emitter, op: Op, *, is_signed: bool, largest: bool) -> bool:
    """Emits the minimum or maximum `op` of two words; False where an operand is no sum of words."""
    left, right = (_pair(emitter, op, operand, _DEPTH) for operand in op.args[:2])
    if left is None or right is None:
        return False
    less = emitter.helper(
        op, Opcode.OR, *_less(emitter, op, left, right, is_signed), type_=Type.PRED
    )
    arms = (right.low, left.low) if largest else (left.low, right.low)
    emitter.emit(op, Opcode.SELECT, (less, *arms))
    return True


def abs_wide(emitter: Emitter, op: Op) -> bool:
    """Emits `abs` of two words; False where the operand is no sum of words."""
    pair = _pair(emitter, op, op.args[0], _DEPTH)
    if pair is None:
        return False
    is_negative = emitter.helper(op, Opcode.ICMP_SLT, pair.high, Const(0), type_=Type.PRED)
    negated = emitter.helper(op, Opcode.SUB, Const(0), pair.low)
    emitter.emit(op, Opcode.SELECT, (is_negative, negated, pair.low))
    return True


def shift_right_wide(emitter: Emitter, op: Op) -> bool:
    """Emits a right shift of two words by a constant below 32; False where it cannot."""
    value, amount = op.args
    if not isinstance(amount, Int) or not 0 < amount.value < _WORD:
        return False
    pair = _pair(emitter, op, value, _DEPTH)
    if pair is None:
        return False
    down = emitter.helper(op, Opcode.LSHR, pair.low, Const(amount.value))
    up = emitter.helper(op, Opcode.SHL, pair.high, Const(_WORD - amount.value))
    emitter.emit(op, Opcode.OR, (down, up))
    return True


@dataclass(frozen=True, slots=True)
class HighPhi:
    """The phi of a high word, for the block of the low one, and what its predecessors compute."""

    block: str
    phi: Phi
    computed: dict[str, tuple[Instr, ...]]


def high_phis(emitter: Emitter, names: dict[str, str]) -> list[HighPhi]:
    """The phis that comparisons have asked for; `names` are the blocks' new names.

    Raises
    ------
    KernelError
        A phi joins something that is no sum of words.
    """
    done: dict[str, HighPhi] = {}
    while emitter.wide_phis.keys() - done.keys():
        name = next(name for name in emitter.wide_phis if name not in done)
        ident, op = emitter.wide_phis[name]
        definition = emitter.function.definitions[name]
        assert isinstance(definition, WidePhi)
        incoming: list[tuple[str, Value]] = []
        computed: dict[str, tuple[Instr, ...]] = {}
        for source, operand in definition.incoming:
            emitter.start(source)
            pair = _pair(emitter, op, operand, _DEPTH)
            if pair is None:
                raise KernelError(
                    "the compared integer may not fit in 32 bits", loc=op.loc, hint=WORD_HINT
                )
            incoming.append((names[source], pair.high))
            computed[source] = tuple(emitter.instrs)
        phi = Phi(ident, Type.I32, tuple(incoming), definition.loc)
        done[name] = HighPhi(emitter.function.block_of[name], phi, computed)
    return list(done.values())


def _less(
    emitter: Emitter,
    op: Op,
    left: _Pair,
    right: _Pair,
    is_signed: bool,
    *,
    or_equal: bool = False,
) -> tuple[Value, Value]:
    """left < right is the disjunction of the two: by the high words, or by the low ones."""
    high_less = Opcode.ICMP_SLT if is_signed else Opcode.ICMP_ULT
    low_less = Opcode.ICMP_ULE if or_equal else Opcode.ICMP_ULT
    before = emitter.helper(op, high_less, left.high, right.high, type_=Type.PRED)
    level = emitter.helper(op, Opcode.ICMP_EQ, left.high, right.high, type_=Type.PRED)
    low = emitter.helper(op, low_less, left.low, right.low, type_=Type.PRED)
    return before, emitter.helper(op, Opcode.AND, level, low, type_=Type.PRED)


def _pair(emitter: Emitter, op: Op, operand: Operand, depth: int) -> _Pair | None:
    if isinstance(operand, Int):
        return _Pair(Const(operand.value & _MASK), Const(operand.value >> 32 & _MASK))
    if emitter.signed(operand):
        low = emitter.value(operand)
        if emitter.range(operand)[0] >= 0:
            return _Pair(low, Const(0))
        return _Pair(low, emitter.helper(op, Opcode.ASHR, low, _SIGN_SHIFT))
    if emitter.unsigned(operand):
        return _Pair(emitter.value(operand), Const(0))
    return _derived(emitter, op, operand, depth)


def _derived(emitter: Emitter, op: Op, operand: Operand, depth: int) -> _Pair | None:
    """The pair of a phi, sum, difference or select; a phi's high word is a phi of its own, which
    `high_phis` fills in.
    """
    definition = (
        emitter.function.definitions.get(operand.name) if isinstance(operand, Local) else None
    )
    if definition is None or definition.type != "i64" or depth == 0:
        return None
    low = emitter.value(operand)
    if isinstance(definition, WidePhi):
        known = emitter.wide_phis.get(definition.name)
        ident = emitter.fresh() if known is None else known[0]
        emitter.wide_phis[definition.name] = (ident, op)
        return _Pair(low, Ref(ident))
    if definition.op not in ("add", "sub", "select"):
        return None
    left, right = (_pair(emitter, op, arg, depth - 1) for arg in definition.args[-2:])
    if left is None or right is None:
        return None
    return _Pair(low, _high_word(emitter, op, definition, low, (left, right)))


def _high_word(
    emitter: Emitter, op: Op, definition: Op, low: Value, pairs: tuple[_Pair, _Pair]
) -> Value:
    """The high word of a sum or difference takes the carry or borrow of the low one."""
    left, right = pairs
    if definition.op == "select":
        condition = emitter.value(definition.args[0])
        return emitter.helper(op, Opcode.SELECT, condition, left.high, right.high)
    if definition.op == "add":
        carry = emitter.helper(op, Opcode.ICMP_ULT, low, left.low, type_=Type.PRED)
        high = emitter.helper(op, Opcode.ADD, left.high, right.high)
        return emitter.helper(op, Opcode.ADD, high, carry)
    borrow = emitter.helper(op, Opcode.ICMP_ULT, left.low, right.low, type_=Type.PRED)
    high = emitter.helper(op, Opcode.SUB, left.high, right.high)
    return emitter.helper(op, Opcode.SUB, high, borrow)
