"""What the translations of integers and of floats share: numbering, operands, and the proof that a
word suffices.
"""

from __future__ import annotations

import numpy as np

from vividc.errors import InternalError, KernelError, SourceLoc
from vividc.frontend.advice import Advice
from vividc.frontend.narrow.demand import demanded_bits
from vividc.frontend.narrow.demand_high import WordFacts, high_words, types_of
from vividc.frontend.ranges.interval import S32, U32, Interval, contains
from vividc.frontend.ranges.ranges import Ranges
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import HIGH_SUFFIX
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import (
    Const,
    Float,
    Function,
    Input,
    Instr,
    Int,
    Kind,
    Named,
    Ref,
    Value,
    type_of,
)

# Free in words: the result is the operand (conversions to or from less than a word apart).
ALIASES = frozenset({"sext", "zext", "trunc", "fpext", "fptrunc", "bitcast", "freeze"})
WORD_HINT = Advice(
    "wrap the result in np.int32(...), or bound it with a comparison before; "
    "a range with a step: range(0, min(n, len(x)), 2)",
    c="cast the result to int32_t, or bound it with a comparison before",
)
_DEPTH = 4


def word_type(type_: Kind) -> Type:
    """Type of the word that holds a value of an LLVM type."""
    if type_ == "i1":
        return Type.PRED
    return Type.F32 if type_ in ("float", "double") else Type.I32


def constant(operand: Int | Float) -> Const:
    """The word of a constant; doubles are rounded to float32."""
    if isinstance(operand, Int):
        return Const(operand.value & WORD_MASK)
    with np.errstate(over="ignore"):
        return Const(int(np.float32(operand.value).view(np.uint32)))


class Emitter:
    """Instructions of the current block."""

    def __init__(
        self, function: Function, ranges: Ranges, ids: dict[int, int], *, returned: bool
    ) -> None:
        self.function = function
        self.ids = ids
        self.instrs: list[Instr] = []
        self.demoted: list[SourceLoc | None] = []
        self.saturated: list[SourceLoc | None] = []
        self._ranges = ranges
        self._demand = demanded_bits(function)
        self._types = types_of(function)
        self._block = ""
        self._next = len(ids)
        needed = high_words(function, ranges, self._demand, returned=returned)
        # In the function's order, so that two runs give the same numbers.
        self.high_ids = {name: self.fresh() for name in self._types if name in needed}

    def start(self, block: str) -> None:
        """Begin a block."""
        self._block = block
        self.instrs = []

    def id_of(self, op: Instr) -> int:
        """Number of the instruction that yields `op`'s result."""
        return self.ids[op.id] if op.id in self.ids else self.fresh()

    def fresh(self) -> int:
        """A number for an instruction of ours."""
        self._next += 1
        return self._next - 1

    def emit(self, op: Instr, opcode: Opcode, operands: tuple[Value, ...]) -> Ref:
        """The instruction that yields `op`'s result."""
        kind = "i1" if op.op in ("icmp", "fcmp") else op.type
        exact = op.op in ("add", "sub") and self._cannot_wrap(op)
        return self._append(self.id_of(op), opcode, word_type(kind), operands, op.loc, exact)

    def _cannot_wrap(self, op: Instr) -> bool:
        (a, b), (c, d) = (self.range(arg) for arg in op.operands)
        return contains(S32, (a + c, b + d) if op.op == "add" else (a - d, b - c))

    def helper(self, op: Instr, opcode: Opcode, *operands: Value, type_: Type = Type.I32) -> Ref:
        """An instruction on the way to `op`'s result."""
        return self._append(self.fresh(), opcode, type_, operands, op.loc)

    def value(self, operand: Value) -> Value:
        """The word that holds an operand."""
        while isinstance(operand, Ref) and operand.id not in self.ids:
            definition = self.function.definitions[operand.id]
            assert isinstance(definition, Instr)
            operand = definition.operands[0]
        if isinstance(operand, Ref):
            return Ref(self.ids[operand.id])
        if isinstance(operand, Input):
            return operand
        if isinstance(operand, Int | Float):
            return constant(operand)
        raise InternalError(f"an address or an aggregate is used as a value: {operand}")

    def known_high(self, operand: Value) -> Value | None:
        """The high word of a 64-bit integer; None if that is the sign of its word."""
        if isinstance(operand, Int):
            return Const(operand.value >> WORD_BITS & WORD_MASK)
        if self.unsigned(operand):
            return Const(0)
        assert isinstance(operand, Named)
        if operand.key in self.high_ids:
            if isinstance(operand, Ref):
                return Ref(self.high_ids[operand.id])
            return Input(operand.key + HIGH_SUFFIX)
        if not self.signed(operand):
            raise InternalError(f"nothing gives the high word of {operand.key}")
        return None

    @property
    def facts(self) -> WordFacts:
        """What is known of words in the current block."""
        return WordFacts(self._ranges, self._demand, self._types, self._block)

    def range(self, operand: Value) -> Interval:
        """Values of an integer operand here."""
        return self._ranges.at(operand, self._block)

    def range_at(self, operand: Value, block: str) -> Interval:
        """Values of an integer operand in a block."""
        return self._ranges.at(operand, block)

    def demand(self, op: Instr) -> int:
        """Low bits of `op`'s result that anything reads."""
        return self._demand.get(op.id, 0)

    def signed(self, *operands: Value) -> bool:
        """Whether sign-extending the words gives the values."""
        return all(contains(S32, self.range(operand)) for operand in operands)

    def unsigned(self, *operands: Value) -> bool:
        """Whether zero-extending the words gives the values."""
        return all(contains(U32, self.range(operand)) for operand in operands)

    def require_signed(self, operand: Value, loc: SourceLoc | None, what: str, hint: str) -> None:
        """Refuse the kernel unless the value fits in a signed word."""
        if not self.signed(operand):
            raise KernelError(
                f"{what} may not fit in 32 bits{self._range_text(operand)}", loc=loc, hint=hint
            )

    def _range_text(self, operand: Value) -> str:
        low, high = self.range(operand)
        return f" (its range is {low} to {high})" if abs(low) < 2**62 and abs(high) < 2**62 else ""

    def is_nonzero(self, operand: Value) -> bool:
        """Whether an integer operand is known not to be 0 here."""
        return self._ranges.is_nonzero(operand, self._block)

    def is_invariant(self, operand: Value) -> bool:
        """Whether the innermost loop around here leaves an operand as it is; False outside."""
        bodies = [body for body in self._ranges.flow.loops.values() if self._block in body]
        return bool(bodies) and self._is_outside(operand, min(bodies, key=len), _DEPTH)

    def _is_outside(self, operand: Value, body: frozenset[str], depth: int) -> bool:
        """Whether an operand is computed outside the loop, or could be."""
        definition = (
            self.function.definitions.get(operand.key) if isinstance(operand, Named) else None
        )
        if definition is None or self.function.block_of[definition.id] not in body:
            return True
        if not isinstance(definition, Instr) or definition.op in ("load", "call") or depth == 0:
            return False
        return all(self._is_outside(arg, body, depth - 1) for arg in definition.operands)

    def type_of(self, operand: Value) -> str:
        """LLVM type of a local ("" for a constant)."""
        return type_of(self.function, operand)

    def demote(self, op: Instr) -> None:
        """Note that `op` computes in float64 what will be computed in float32."""
        self.demoted.append(op.loc)

    def _append(
        self,
        id_: int,
        opcode: Opcode,
        type_: Type,
        operands: tuple[Value, ...],
        loc: SourceLoc | None,
        exact: bool = False,
    ) -> Ref:
        self.instrs.append(Instr(id_, opcode, type_, operands, exact=exact, loc=loc))
        return Ref(id_)
