"""Arithmetic on 64-bit integers as two words: what the rules for wide operations compute with.

The formulas are those of multiple-word arithmetic (Warren, "Hacker's Delight", 2nd ed. 2012,
chapters 2 and 8). Operations of constants are folded on the spot, so that a formula is written once
for all operands.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from vividc.frontend.narrow.emit import Emitter, word_type
from vividc.frontend.ranges.interval import Interval
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.machine.semantics import evaluate
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import Const, Instr, Ref, Value

ZERO = Const(0)
_SIGN_SHIFT = 31
_RIGHT_ZERO = frozenset(
    {Opcode.ADD, Opcode.SUB, Opcode.OR, Opcode.XOR, Opcode.SHL, Opcode.LSHR, Opcode.ASHR}
)
_COMMUTING = frozenset({Opcode.ADD, Opcode.OR, Opcode.XOR, Opcode.AND, Opcode.MUL, Opcode.MULHU})
_ABSORBED = frozenset({Opcode.AND, Opcode.MUL, Opcode.MULHU, Opcode.MULHS})
_ONES = Const(WORD_MASK)
_NEUTRAL = frozenset({(Opcode.MUL, Const(1)), (Opcode.AND, _ONES)})
_BINARY = 2
_SHIFTS = frozenset({Opcode.SHL, Opcode.LSHR, Opcode.ASHR})


class Pair(NamedTuple):
    """A 64-bit integer: its words."""

    low: Value
    high: Value


class Words:
    """Emits the operations on the way to the result of one wide instruction."""

    def __init__(self, emitter: Emitter, op: Instr) -> None:
        self.emitter = emitter
        self._op = op
        self._start = len(emitter.instrs)

    def pair(self, operand: Value) -> Pair:
        """Both words of an operand."""
        return Pair(self.emitter.value(operand), self.high(operand))

    def high(self, operand: Value) -> Value:
        """The high word of an operand: known, computed beside the low one, or its extension."""
        known = self.emitter.known_high(operand)
        if known is not None:
            return known
        return self.op(Opcode.ASHR, self.emitter.value(operand), _SIGN_SHIFT)

    def range(self, operand: Value) -> Interval:
        """Values of an operand here."""
        return self.emitter.range(operand)

    def op(self, opcode: Opcode, *operands: Value | int) -> Value:
        """One operation; an int operand is a constant's word."""
        values = tuple(Const(v & WORD_MASK) if isinstance(v, int) else v for v in operands)
        known = _folded(opcode, values)
        if known is not None:
            return known
        type_ = OPCODES[opcode].result
        if type_ is Type.ANY:
            type_ = Type.I32
        return self.emitter.helper(self._op, opcode, *values, type_=type_)

    def both(self, a: Value, b: Value) -> Value:
        """Conjunction of predicates."""
        return self._logic(Opcode.AND, a, b)

    def either(self, a: Value, b: Value) -> Value:
        """Disjunction of predicates."""
        return self._logic(Opcode.OR, a, b)

    def either_only(self, a: Value, b: Value) -> Value:
        """Whether one of two predicates holds, and not the other."""
        if isinstance(a, Const):
            a, b = b, a
        if isinstance(b, Const):
            return self.negated(a) if b.word else a
        return self.emitter.helper(self._op, Opcode.XOR, a, b, type_=Type.PRED)

    def _logic(self, opcode: Opcode, a: Value, b: Value) -> Value:
        if isinstance(a, Const):
            a, b = b, a
        if isinstance(b, Const):
            keeps = b.word == (1 if opcode is Opcode.AND else 0)
            return a if keeps else b
        return self.emitter.helper(self._op, opcode, a, b, type_=Type.PRED)

    def negated(self, predicate: Value) -> Value:
        """The opposite of a predicate."""
        if isinstance(predicate, Const):
            return Const(1 - predicate.word)
        return self.emitter.helper(self._op, Opcode.XOR, predicate, Const(1), type_=Type.PRED)

    def select(self, condition: Value, yes: Pair, no: Pair) -> Pair:
        """One of two integers."""
        return Pair(
            self.choose(condition, yes.low, no.low), self.choose(condition, *_highs(yes, no))
        )

    def choose(self, condition: Value, yes: Value, no: Value, *, type_: Type = Type.I32) -> Value:
        """One of two words, or of two predicates."""
        if yes == no:
            return yes
        if isinstance(condition, Const):
            return yes if condition.word else no
        return self.emitter.helper(self._op, Opcode.SELECT, condition, yes, no, type_=type_)

    def add(self, a: Pair, b: Pair) -> Pair:
        """a + b modulo 2**64."""
        low = self.op(Opcode.ADD, a.low, b.low)
        carry = ZERO if ZERO in (a.low, b.low) else self.op(Opcode.ICMP_ULT, low, a.low)
        return Pair(low, self.op(Opcode.ADD, self.op(Opcode.ADD, a.high, b.high), carry))

    def sub(self, a: Pair, b: Pair) -> Pair:
        """a - b modulo 2**64."""
        low = self.op(Opcode.SUB, a.low, b.low)
        borrow = self.op(Opcode.ICMP_ULT, a.low, b.low)
        return Pair(low, self.op(Opcode.SUB, self.op(Opcode.SUB, a.high, b.high), borrow))

    def negate_if(self, a: Pair, sign: Value) -> Pair:
        """-a where the word `sign` is all ones, a where it is 0."""
        flipped = Pair(*(self.op(Opcode.XOR, word, sign) for word in a))
        return self.sub(flipped, Pair(sign, sign))

    def mul(self, a: Pair, b: Pair) -> Pair:
        """a * b modulo 2**64."""
        low, high = self.product(a.low, b.low)
        for one, other in ((a.low, b.high), (a.high, b.low)):
            high = self.op(Opcode.ADD, high, self.op(Opcode.MUL, one, other))
        return Pair(low, high)

    def product(self, a: Value, b: Value) -> Pair:
        """The product of two unsigned words."""
        return Pair(self.op(Opcode.MUL, a, b), self.op(Opcode.MULHU, a, b))

    def logic(self, opcode: Opcode, a: Pair, b: Pair) -> Pair:
        """and, or, xor."""
        return Pair(*(self.op(opcode, one, other) for one, other in zip(a, b, strict=True)))

    def equal(self, a: Pair, b: Pair) -> Value:
        """a == b as a predicate."""
        if ZERO in (a.low, a.high) and a.low == a.high:
            a, b = b, a
        if b == Pair(ZERO, ZERO):
            return self.op(Opcode.ICMP_EQ, self.op(Opcode.OR, *a), ZERO)
        lows = self.op(Opcode.ICMP_EQ, a.low, b.low)
        return self.both(lows, self.op(Opcode.ICMP_EQ, a.high, b.high))

    def less(self, a: Pair, b: Pair, *, signed: bool, or_equal: bool = False) -> Value:
        """a < b (or a <= b) as a predicate."""
        low = self.op(Opcode.ICMP_ULE if or_equal else Opcode.ICMP_ULT, a.low, b.low)
        before = self.op(Opcode.ICMP_SLT if signed else Opcode.ICMP_ULT, a.high, b.high)
        if low == Const(0):
            return before
        level = self.op(Opcode.ICMP_EQ, a.high, b.high)
        return self.either(before, self.both(level, low))

    def sign(self, a: Pair) -> Value:
        """All ones where a is negative, else 0."""
        return self.op(Opcode.ASHR, a.high, _SIGN_SHIFT)

    def results(self, low: int | None, high: int | None, value: Pair | Value) -> None:
        """Number the words of the result, and drop what computes neither."""
        emitter = self.emitter
        emitted = emitter.instrs[self._start :]
        del emitter.instrs[self._start :]
        pair = value if isinstance(value, Pair) else Pair(value, ZERO)
        compares = self._op.op in ("icmp", "fcmp")
        type_ = word_type("i1" if compares else self._op.type)
        renamed: dict[Value, Ref] = {}
        moves: list[tuple[int, Value]] = []
        own = {Ref(instr.id) for instr in emitted}
        for ident, word in ((low, pair.low), (high, pair.high)):
            if ident is None:
                continue
            if word in own and word not in renamed:
                renamed[word] = Ref(ident)
            else:
                moves.append((ident, word))
        for instr in _live(emitted, renamed, moves):
            emitter.instrs.append(replace(instr, type=type_) if instr.id == low else instr)
        for ident, word in moves:
            kind = type_ if ident == low else Type.I32
            source = renamed.get(word, word)
            emitter.instrs.append(Instr(ident, Opcode.MOV, kind, (source,), loc=self._op.loc))


def _highs(yes: Pair, no: Pair) -> tuple[Value, Value]:
    return yes.high, no.high


def _folded(opcode: Opcode, values: tuple[Value, ...]) -> Value | None:
    if all(isinstance(value, Const) for value in values):
        words = [value.word for value in values if isinstance(value, Const)]
        return Const(evaluate(opcode, words))
    if OPCODES[opcode].arity != _BINARY:
        return None
    a, b = values
    if isinstance(a, Const) and opcode in _COMMUTING:
        a, b = b, a
    return _with_zero(opcode, a) if b == ZERO else _with_constant(opcode, a, b)


def _with_constant(opcode: Opcode, a: Value, b: Value) -> Value | None:
    """The result of an operation of a constant other than `b` = 0, if it is known."""
    if (opcode, b) in _NEUTRAL:
        return a
    if opcode is Opcode.ICMP_ULE and a == ZERO:
        return Const(1)
    is_zero = (a == ZERO and opcode in _SHIFTS) or (opcode is Opcode.ICMP_ULT and a == _ONES)
    return ZERO if is_zero else None


def _with_zero(opcode: Opcode, a: Value) -> Value | None:
    if opcode in _RIGHT_ZERO:
        return a
    return ZERO if opcode in _ABSORBED or opcode is Opcode.ICMP_ULT else None


def _live(
    emitted: list[Instr], renamed: dict[Value, Ref], moves: list[tuple[int, Value]]
) -> list[Instr]:
    """The instructions that results need, under their new numbers."""
    needed = {*renamed, *(word for _, word in moves)}
    kept: list[Instr] = []
    for instr in reversed(emitted):
        if Ref(instr.id) in needed:
            needed.update(instr.operands)
            operands = tuple(renamed.get(value, value) for value in instr.operands)
            ident = renamed.get(Ref(instr.id), Ref(instr.id)).id
            kept.append(replace(instr, id=ident, operands=operands))
    return kept[::-1]
