"""Comparisons of 64-bit integers whose values need more than a word: in two words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from vividc.dfg.cfg import Const, Instr, Phi, Ref, Value
from vividc.dfg.opcodes import Opcode, Type
from vividc.errors import KernelError
from vividc.frontend.emit import Emitter
from vividc.frontend.ssa import Int, Local, Op, Operand, WidePhi

_MASK = 0xFFFFFFFF
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
    _emit_less(emitter, op, left, right, or_equal=op.pred[2] == "e")
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


def _emit_less(emitter: Emitter, op: Op, left: _Pair, right: _Pair, *, or_equal: bool) -> None:
    high_less = Opcode.ICMP_SLT if op.pred[0] == "s" else Opcode.ICMP_ULT
    low_less = Opcode.ICMP_ULE if or_equal else Opcode.ICMP_ULT
    before = emitter.helper(op, high_less, left.high, right.high, type_=Type.PRED)
    level = emitter.helper(op, Opcode.ICMP_EQ, left.high, right.high, type_=Type.PRED)
    low = emitter.helper(op, low_less, left.low, right.low, type_=Type.PRED)
    tied = emitter.helper(op, Opcode.AND, level, low, type_=Type.PRED)
    emitter.emit(op, Opcode.OR, (before, tied))


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
    return _sum(emitter, op, operand, depth)


def _sum(emitter: Emitter, op: Op, operand: Operand, depth: int) -> _Pair | None:
    """The high word of a sum or difference takes the carry or borrow of the low one; that of a phi
    is a phi of its own, which `high_phis` fills in.
    """
    if not isinstance(operand, Local) or depth == 0:
        return None
    definition = emitter.function.definitions.get(operand.name)
    if isinstance(definition, WidePhi) and definition.type == "i64":
        known = emitter.wide_phis.get(operand.name)
        ident = emitter.fresh() if known is None else known[0]
        emitter.wide_phis[operand.name] = (ident, op)
        return _Pair(emitter.value(operand), Ref(ident))
    if not isinstance(definition, Op) or definition.op not in ("add", "sub"):
        return None
    left, right = (_pair(emitter, op, arg, depth - 1) for arg in definition.args)
    if left is None or right is None:
        return None
    low = emitter.value(operand)
    if definition.op == "add":
        carry = emitter.helper(op, Opcode.ICMP_ULT, low, left.low, type_=Type.PRED)
        high = emitter.helper(op, Opcode.ADD, left.high, right.high)
        return _Pair(low, emitter.helper(op, Opcode.ADD, high, carry))
    borrow = emitter.helper(op, Opcode.ICMP_ULT, left.low, right.low, type_=Type.PRED)
    high = emitter.helper(op, Opcode.SUB, left.high, right.high)
    return _Pair(low, emitter.helper(op, Opcode.SUB, high, borrow))
