"""Addresses of accesses as sums of words of which a region's iteration is one.

Where two accesses of a cycle meet in a bank, their addresses differ by a multiple of the banks; the
difference is known where words that nobody knows cancel, or are multiples themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from vividc.dfg.ir import CHANGES, FROM_END, AddressForm
from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.induction import induction_of, is_invariant
from vividc.ssa.analysis.polynomial import (
    ITERATION,
    LoopPolynomials,
    Monomial,
    Polynomial,
    constant,
    symbol,
)
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Const, Function, Input, Instr, Phi, Ref, Value, definition_of
from vividc.ssa.polyhedral.subscripts import Subscripts, subscripts_of


@dataclass
class AddressForms:
    """Forms of the accesses of a loop's body, or of straight code."""

    function: Function
    loop: Loop | None = None
    _memo: dict[Value, Polynomial] = field(init=False, default_factory=dict)

    @cached_property
    def _iterations(self) -> LoopPolynomials | None:
        return None if self.loop is None else LoopPolynomials(self.function, self.loop, True)

    @property
    def _subscripts(self) -> Subscripts:
        return subscripts_of(self.function)

    @cached_property
    def _outer(self) -> dict[Value, Loop]:
        """The loop of each phi of a header."""
        return {
            Ref(phi.id): loop
            for loop in find_loops(self.function)
            for phi in self.function.by_name[loop.header].phis
        }

    def of(self, access: Instr) -> AddressForm:
        """The form of an access's address."""
        first, index = access.operands[:2]
        total = self._value(index).times(constant(1 << access.shift))
        total = total.plus(self._value(first)).plus(constant(access.offset))
        return tuple((tuple(map(_name, m)), factor) for m, factor in total.terms.items())

    def _taken_apart(self, form: Polynomial) -> Polynomial:
        total = Polynomial({})
        for monomial, factor in form.terms.items():
            total = total.plus(self._product(monomial), factor)
        return total

    def _product(self, monomial: Monomial) -> Polynomial:
        product = constant(1)
        for value in monomial:
            product = product.times(self._value(value))
        return product

    def _value(self, value: Value) -> Polynomial:
        if value not in self._memo:
            self._memo[value] = symbol(value)  # what a cycle of phis goes back to
            self._memo[value] = self._found(value)
        return self._memo[value]

    def _found(self, value: Value) -> Polynomial:
        if isinstance(value, Input):
            settled = self.function.settled(value)
            return constant(settled.word) if isinstance(settled, Const) else symbol(settled)
        item = definition_of(self.function, value)
        if isinstance(item, Instr) and _is_end_of_negative(self.function, item):
            return symbol(Input(f"{FROM_END}{value}"))
        parts = self._subscripts.polynomial(value)
        if parts != symbol(value):
            return self._taken_apart(parts)
        if self._iterations is None or is_invariant(
            self.function, self._iterations.loop.blocks, value
        ):
            return self._of_outer(value)
        form = self._iterations.of(value)
        return symbol(Input(f"{CHANGES}{value}")) if form is None else self._taken_apart(form)

    def _of_outer(self, value: Value) -> Polynomial:
        """A word from outside the loop: of a counter, by how often its loop went round."""
        item, loop = definition_of(self.function, value), self._outer.get(value)
        if not isinstance(item, Phi) or loop is None:
            return symbol(value)
        induction = induction_of(self.function, loop.blocks, item)
        if induction is None or induction.start is None or induction.step is None:
            return symbol(value)
        counted = symbol(Input(f"{loop.header} {ITERATION.key}")).times(constant(induction.step))
        return self._value(induction.start).plus(counted)


def _is_end_of_negative(function: Function, instr: Instr) -> bool:
    """Whether it is what a subscript is counted from: the array's length where it is negative."""
    if instr.op is not Opcode.SELECT:
        return False
    test = definition_of(function, instr.operands[0])
    if not isinstance(test, Instr) or test.op is not Opcode.ICMP_SLT:
        return False
    return test.operands[1] == instr.operands[2] == Const(0)


def _name(value: Value) -> str:
    return value.key if isinstance(value, Input) else str(value)
