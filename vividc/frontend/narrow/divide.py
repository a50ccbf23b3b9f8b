"""Integer division and remainder in words: LLVM's, which truncates, and Python's, which rounds
down.

Each operand is a word that is its value's zero or sign extension. Where neither can be negative the
division is the machine's unsigned one. Else signs are taken off the operands and put on the result:
for b > 0 and s = -1 where a < 0, else 0, floor(a / b) is ((a ^ s) / b) ^ s, since a ^ -1 = -a - 1;
a negative divisor negates both operands first.

By a constant, and by a value that the loop around does not change, the division is a
multiplication: with x = floor((2**32 - 1) / b) the high word of n * x is the quotient or one less.
x is written as a division too, which `hoist_invariants` moves out of the loop.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.errors import KernelError
from vividc.frontend.narrow.emit import Emitter
from vividc.frontend.narrow.small import sign_extended, signed_range
from vividc.frontend.ranges.interval import S32, U32, Interval, contains, width
from vividc.machine.division import multiplier, quotient_by_constant, remainder_by_constant
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Const, Instr, Value

_SIGN = 31


@dataclass(frozen=True, slots=True)
class _Term:
    """An operand: its word, and the values that it can have."""

    word: Value
    range: Interval
    source: Value

    @property
    def is_signed(self) -> bool:
        """Whether the word is to be read as signed."""
        return self.range[0] < 0

    @property
    def constant(self) -> int | None:
        """The only value, if the word is a constant."""
        return self.range[0] if isinstance(self.word, Const) else None

    @property
    def magnitude(self) -> int:
        """The largest magnitude."""
        return max(abs(bound) for bound in self.range)


def divide(emitter: Emitter, op: Instr, hint: str) -> None:
    """Write the division or remainder `op`; refused with `hint` if an operand may fit no word.

    Raises
    ------
    KernelError
        No word holds an operand.
    """
    result = _Division(emitter, op, hint).result(is_quotient=op.mnemonic.endswith("div"))
    bits = width(op.type)
    if bits < WORD_BITS:
        emitter.emit(op, Opcode.AND, (result, Const((1 << bits) - 1)))
    else:
        emitter.emit(op, Opcode.MOV, (result,))


class _Division:
    """One division: its operands, and the instructions that it writes."""

    def __init__(self, emitter: Emitter, op: Instr, hint: str) -> None:
        self._emitter = emitter
        self._op = op
        self._hint = hint
        self._rounds_down = "floor" in op.mnemonic
        self._dividend = self._term(op.operands[0], "the dividend")
        self._divisor = self._term(op.operands[1], "the divisor")
        # By zero Python's is 0; LLVM's has no meaning.
        self._may_be_zero = self._rounds_down and not emitter.is_nonzero(op.operands[1])

    def result(self, *, is_quotient: bool) -> Value:
        """The word of the result."""
        self._guard_zero(is_quotient)
        a, b = self._dividend, self._divisor
        if not a.is_signed and not b.is_signed:
            return self._unsigned(a.word, a.range[1], b.word, is_quotient)
        if not self._rounds_down:
            return self._truncated(is_quotient)
        if b.constant is not None and b.constant > 0:
            biased = self._biased(b.constant, is_quotient)
            if biased is not None:
                return biased
        return self._floor(is_quotient)

    def _term(self, operand: Value, what: str) -> _Term:
        emitter, op = self._emitter, self._op
        bits, is_signed = width(op.type), op.mnemonic[0] == "s"
        interval = emitter.range(operand)
        if bits < WORD_BITS and is_signed:
            word = sign_extended(emitter, op, operand, bits)
            return _Term(word, signed_range(interval, bits), operand)
        if bits == WORD_BITS and not is_signed and interval[0] < 0:
            interval = _as_unsigned(interval)
        if not contains(U32, interval) and not (is_signed and contains(S32, interval)):
            emitter.require_signed(operand, op.loc, what, self._hint)
            raise KernelError(
                f"{what} may be negative and is divided as unsigned", loc=op.loc, hint=self._hint
            )
        return _Term(emitter.value(operand), interval, operand)

    def _emit(self, opcode: Opcode, *operands: Value | int) -> Value:
        values = tuple(
            Const(operand & WORD_MASK) if isinstance(operand, int) else operand
            for operand in operands
        )
        info = OPCODES[opcode]
        kind = Type.PRED if info.result is Type.PRED else Type.I32
        return self._emitter.helper(self._op, opcode, *values, type_=kind)

    def _guard_zero(self, is_quotient: bool) -> None:
        """0 / 0 is 0 and leaves 0 by itself. A quotient and remainder of the same operands are made
        alike, so that they share.
        """
        is_shared = self._is_shared(is_quotient)
        if not self._may_be_zero or (is_quotient and not is_shared):
            return
        a, b = self._dividend, self._divisor
        if not is_shared and self._emitter.is_invariant(b.source):
            one = self._emit(Opcode.ICMP_EQ, b.word, 0)
            self._divisor = replace(b, word=self._emit(Opcode.ADD, b.word, one))
        else:
            exists = self._emit(Opcode.ICMP_NE, b.word, 0)
            self._dividend = replace(a, word=self._emit(Opcode.SELECT, exists, a.word, 0))
        self._may_be_zero = False

    def _is_shared(self, is_quotient: bool) -> bool:
        other = self._op.mnemonic[:-3] + ("rem" if is_quotient else "div")
        definitions = self._emitter.function.definitions.values()
        return any(
            isinstance(item, Instr) and item.op == other and item.operands == self._op.operands
            for item in definitions
        )

    def _truncated(self, is_quotient: bool) -> Value:
        """From the magnitudes; the quotient has both signs, the remainder the dividend's."""
        a, b = self._dividend, self._divisor
        if is_quotient and b.constant is not None and b.constant > 0:
            return self._truncated_by_constant(b.constant)
        magnitude = self._unsigned(self._magnitude(a), a.magnitude, self._magnitude(b), is_quotient)
        if not is_quotient:
            return self._with_sign(magnitude, a.word) if a.is_signed else magnitude
        signed = [term.word for term in (a, b) if term.is_signed]
        sign = signed[0] if len(signed) == 1 else self._emit(Opcode.XOR, *signed)
        return self._with_sign(magnitude, sign)

    def _truncated_by_constant(self, divisor: int) -> Value:
        """The product rounds down: a negative quotient is one too low (Granlund and Montgomery
        1994, section 5). By a power of two the dividend is corrected before.
        """
        a = self._dividend
        if divisor > a.magnitude:
            return Const(0)
        sign = self._emit(Opcode.ASHR, a.word, _SIGN)
        power = divisor.bit_length() - 1
        if divisor == 1 << power:
            if power == 0:
                return a.word
            bias = self._emit(Opcode.LSHR, sign, WORD_BITS - power)
            return self._emit(Opcode.ASHR, self._emit(Opcode.ADD, a.word, bias), power)
        by = multiplier(divisor, a.magnitude)
        if by.factor >> _SIGN or by.before or by.increment:
            magnitude = self._by_constant(self._magnitude(a), a.magnitude, divisor, True)
            return self._with_sign(magnitude, a.word)
        high = self._emit(Opcode.MULHS, a.word, by.factor)
        if by.after:
            high = self._emit(Opcode.ASHR, high, by.after)
        return self._emit(Opcode.SUB, high, sign)

    def _magnitude(self, term: _Term) -> Value:
        if not term.is_signed:
            return term.word
        if term.constant is not None:
            return Const(-term.constant)
        return self._emit(Opcode.SMAX, term.word, self._emit(Opcode.SUB, 0, term.word))

    def _with_sign(self, magnitude: Value, word: Value) -> Value:
        """The magnitude with the sign of `word`."""
        if isinstance(word, Const):
            return self._emit(Opcode.SUB, 0, magnitude) if word.word >> _SIGN else magnitude
        sign = self._emit(Opcode.ASHR, word, _SIGN)
        return self._emit(Opcode.SUB, self._emit(Opcode.XOR, magnitude, sign), sign)

    def _biased(self, divisor: int, is_quotient: bool) -> Value | None:
        """A dividend of few negative values is made positive by a multiple of the divisor."""
        a = self._dividend
        multiple = -(a.range[0] // divisor)
        largest = a.range[1] + multiple * divisor
        if largest > WORD_MASK or largest < 0:
            return None
        shifted = self._emit(Opcode.ADD, a.word, multiple * divisor)
        result = self._by_constant(shifted, largest, divisor, is_quotient)
        return self._emit(Opcode.SUB, result, multiple) if is_quotient else result

    def _floor(self, is_quotient: bool) -> Value:
        """By the identities of the module's docstring."""
        a, b = self._dividend, self._divisor
        divisor, dividend, negative = b.word, a.word, None
        if b.is_signed:
            negative = self._emit(Opcode.ASHR, b.word, _SIGN)
            divisor = self._magnitude(b)
            dividend = self._emit(Opcode.SUB, self._emit(Opcode.XOR, a.word, negative), negative)
        sign = self._floor_sign(dividend)
        largest = a.magnitude if b.is_signed else max(a.range[1], ~a.range[0])
        flipped = self._emit(Opcode.XOR, dividend, sign)
        result = self._unsigned(flipped, largest, divisor, is_quotient)
        if is_quotient:
            if self._may_be_zero:
                exists = self._emit(Opcode.ICMP_NE, b.word, 0)
                sign = self._emit(Opcode.SELECT, exists, sign, 0)
            return self._emit(Opcode.XOR, result, sign)
        # divisor - 1 - result where the dividend was flipped
        flipped = self._emit(Opcode.XOR, result, sign)
        remainder = self._emit(Opcode.ADD, flipped, self._emit(Opcode.AND, sign, divisor))
        if negative is None:
            return remainder
        return self._emit(Opcode.SUB, self._emit(Opcode.XOR, remainder, negative), negative)

    def _floor_sign(self, dividend: Value) -> Value:
        """-1 where the quotient's exact value is negative, else 0; `dividend`: negated with the
        divisor. The word of -INT_MIN is negative, but its operands have the same sign.
        """
        a, b = self._dividend, self._divisor
        if not b.is_signed:
            return self._emit(Opcode.ASHR, dividend, _SIGN)
        if not a.is_signed:
            positive = self._emit(Opcode.ICMP_NE, dividend, 0)
            negative = self._emit(Opcode.ASHR, b.word, _SIGN)
            return self._emit(Opcode.SELECT, positive, negative, 0)
        differ = self._emit(Opcode.XOR, a.word, b.word)
        return self._emit(Opcode.ASHR, self._emit(Opcode.AND, dividend, differ), _SIGN)

    def _unsigned(self, dividend: Value, largest: int, divisor: Value, is_quotient: bool) -> Value:
        """dividend / divisor or what it leaves; `largest`: the largest dividend."""
        if isinstance(divisor, Const):
            return self._by_constant(dividend, largest, divisor.word, is_quotient)
        if self._emitter.is_invariant(self._divisor.source):
            return self._by_reciprocal(dividend, divisor, is_quotient)
        return self._emit(Opcode.UDIV if is_quotient else Opcode.UREM, dividend, divisor)

    def _by_constant(self, dividend: Value, largest: int, divisor: int, is_quotient: bool) -> Value:
        if divisor == 0:
            return Const(0)
        rule = quotient_by_constant if is_quotient else remainder_by_constant
        result = rule(self._emit, dividend, divisor, largest)
        return Const(result) if isinstance(result, int) else result

    def _by_reciprocal(self, dividend: Value, divisor: Value, is_quotient: bool) -> Value:
        """All that depends on the divisor alone leaves the loop."""
        reciprocal = self._emit(Opcode.UDIV, WORD_MASK, divisor)
        negated = self._emit(Opcode.SUB, 0, divisor)
        quotient = self._emit(Opcode.MULHU, dividend, reciprocal)
        rest = self._emit(Opcode.ADD, dividend, self._emit(Opcode.MUL, quotient, negated))
        # rest >= divisor, but false for the divisor 0, whose reciprocal is 0.
        low = self._emit(Opcode.ICMP_ULT, self._emit(Opcode.SUB, divisor, 1), rest)
        if is_quotient:
            return self._emit(Opcode.ADD, quotient, low)
        return self._emit(Opcode.SELECT, low, self._emit(Opcode.ADD, negated, rest), rest)


def _as_unsigned(interval: Interval) -> Interval:
    """Of words that are kept as signed."""
    low, high = interval
    return U32 if high >= 0 else (low + 2**WORD_BITS, high + 2**WORD_BITS)
