"""Tests of which one holds wherever another does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.ir import Const, Function, Instr, Ref, Value, definition_of

_CONSTANT: Final = Const(1)
"""Stands in a sum for what no value is a factor of."""


@dataclass(frozen=True, slots=True)
class Implications:
    """Between tests of `function`, and of instructions that it is yet to get, by id."""

    function: Function
    further: Mapping[int, Instr]

    def holds(self, one: Value, other: Value) -> bool:
        """Whether `other` holds wherever `one` does: it is one of the tests whose conjunction `one`
        is, or one of these demands as much or more of the same difference of signed words.
        """
        wanted = self._margin(other)
        return any(
            test == other or (wanted is not None and self._demands(test, wanted))
            for test in self._conjuncts(one)
        )

    def _conjuncts(self, value: Value) -> list[Value]:
        made = self._made(value, Opcode.AND)
        if made is None:
            return [value]
        return [test for operand in made.operands for test in self._conjuncts(operand)]

    def _demands(self, test: Value, wanted: Counter[Value]) -> bool:
        margin = self._margin(test)
        if margin is None:
            return False
        more = Counter(wanted)
        more.subtract(margin)
        constant = more.pop(_CONSTANT, 0)
        return constant >= 0 and not any(more.values())

    def _margin(self, test: Value) -> Counter[Value] | None:
        """What is positive if and only if a comparison of signed words holds."""
        made = self._made(test, Opcode.ICMP_SLT, Opcode.ICMP_SLE)
        if made is None:
            return None
        less, more = made.operands
        margin = Counter[Value]({_CONSTANT: int(made.op is Opcode.ICMP_SLE)})
        margin.update(self._sum(more))
        margin.subtract(self._sum(less))
        return margin

    def _sum(self, value: Value) -> Counter[Value]:
        """A signed word as a sum of whole numbers, each value with its factor: through additions
        that do not wrap.
        """
        value = self.function.settled(value)
        if isinstance(value, Const):
            return Counter({_CONSTANT: signed(value.word)})
        made = self._made(value, Opcode.ADD, Opcode.SUB)
        if made is None or not made.exact:
            return Counter({value: 1})
        total, other = map(self._sum, made.operands)
        (total.update if made.op is Opcode.ADD else total.subtract)(other)
        return total

    def _made(self, value: Value, *ops: Opcode) -> Instr | None:
        """The instruction that makes a value, if it is one of those."""
        further = self.further.get(value.id) if isinstance(value, Ref) else None
        item = further or definition_of(self.function, value)
        return item if isinstance(item, Instr) and item.op in ops else None
