"""What the expansions of elementary functions share: nodes beside the operation they replace."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from vividc.dfg.ir import Node
from vividc.dfg.passes.rewrite import Rewrite, Value
from vividc.machine.opcodes import PRED, Opcode

ONE: Final = 0x3F800000
SIGN: Final = 0x80000000
EXPONENT: Final = 0x7F800000  # the exponent field, which is also infinity
EXPONENT_SHIFT: Final = 23
SMALLEST_NORMAL: Final = 0x00800000
# Magnitude - 1 is unsigned less than this unless the number is 0 (wraps), infinite or NaN.
FINITE_NONZERO: Final = 0x7F7FFFFF


class Builder:
    """Adds operations to a graph, all with the line of the node that they replace."""

    def __init__(
        self,
        rewrite: Rewrite,
        node: Node,
        magnitude: float = math.inf,
        *,
        latency_binds: bool = False,
        divisor_is_last: bool = False,
        has_normal_divisor: bool = False,
    ) -> None:
        self._rewrite = rewrite
        self._loc, self._lane = node.loc, node.lane
        self.magnitude = magnitude
        """What the magnitude of a finite first operand cannot exceed."""
        self.latency_binds = latency_binds
        """Whether fewer cycles are worth more operations."""
        self.divisor_is_last = divisor_is_last
        """Whether a quotient waits for its divisor rather than for its dividend."""
        self.has_normal_divisor = has_normal_divisor
        """Whether a divisor is known not to be subnormal."""

    def op(self, opcode: Opcode, *operands: Value | int, pred: Value | None = None) -> Value:
        """A new operation; an int operand is the word of a constant. Where `pred` is 0 the last
        operand passes.
        """
        node_id = self._rewrite.add_node(opcode, self._values(operands), self._loc, self._lane)
        if self._lane is not None:  # the next operation is another part of the same one
            self._lane = replace(self._lane, part=self._lane.part + 1)
        if pred is not None:
            self._rewrite.set_operand(node_id, PRED, pred)
        return Value(node_id)

    def constant(self, word: int) -> Value:
        """A constant."""
        return Value(self._rewrite.constant(word))

    def word(self, value: Value) -> int | None:
        """The word of a value that is the same constant in every iteration."""
        return self._rewrite.word(value)

    def horner(self, coefficients: Sequence[int], x: Value) -> Value:
        """Polynomial in `x`; coefficients from the highest power (two or more) to the constant."""
        value = self.op(Opcode.FMA, coefficients[0], x, coefficients[1])
        for coefficient in coefficients[2:]:
            value = self.op(Opcode.FMA, value, x, coefficient)
        return value

    def is_finite_nonzero(self, magnitude: Value) -> Value:
        """Whether a word is a positive number other than 0 and infinity."""
        less = self.op(Opcode.SUB, magnitude, 1)
        return self.op(Opcode.ICMP_ULT, less, FINITE_NONZERO)

    def stepped(self, bits: Value, above: Value, below: Value) -> Value:
        """The number above one of these bits where `above` is 1, below it where `below` is."""
        return self.op(Opcode.SUB, self.op(Opcode.ADD, bits, above), below)

    def clamped(self, magnitude: Value, limit: int) -> Value:
        """The smaller of a magnitude and a limit; a NaN stays, as it does not under `fmin`."""
        beyond = self.op(Opcode.FCMP_OLT, limit, magnitude)
        return self.op(Opcode.SELECT, beyond, limit, magnitude)

    def times_sign(self, value: Value, x: Value) -> Value:
        """`value` with the sign changed where x is negative; a product, so that a NaN becomes the
        canonical one.
        """
        sign = self.op(Opcode.OR, self.op(Opcode.AND, x, SIGN), ONE)
        return self.op(Opcode.FMUL, value, sign)

    def _values(self, operands: Sequence[Value | int]) -> list[Value]:
        return [
            operand if isinstance(operand, Value) else self.constant(operand)
            for operand in operands
        ]


Expansion = Callable[..., Value]
"""From a builder and the operands to the result, which is a new operation."""
