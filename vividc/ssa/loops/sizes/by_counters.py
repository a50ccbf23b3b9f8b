"""Numbers that loops count beside their counters, by these.

Numpy's sums along an axis move a pointer from element to element, and back at the end of a row. In
a loop with a counter c from c0 on, what each iteration adds the same number p to is start +
(c - c0) * p; what the loop leaves in its counter is its limit, if that is not below c0. Indices
made of such numbers are polynomials of counters, as those of loops by hand.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_MASK
from vividc.ssa.analysis.counters import Counter, counter_of
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, symbol
from vividc.ssa.edit import FreshIds, map_values, replaced, with_blocks
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Const, Function, Instr, Phi, Ref, Value


def by_counters(function: Function) -> Function:
    """The function without other numbers that its loops count."""
    for header in [loop.header for loop in find_loops(function)]:
        loop = next(one for one in find_loops(function) if one.header == header)
        counter = counter_of(function, loop)
        if counter is not None and counter.step == 1:
            function = _Counted(function, loop, counter).alone()
    return function


@dataclass(frozen=True)
class _Counted:
    """A loop with a counter that rises by 1."""

    function: Function
    loop: Loop
    counter: Counter

    def alone(self) -> Function:
        """The function with what the loop counts made of its counter, and of its limit behind
        it.
        """
        function, loop, counter = self.function, self.loop, self.counter
        before, header = preheader_of(function, loop), function.by_name[loop.header]
        ids, ahead, inside = FreshIds(function), list[Instr](), list[Instr]()
        values: dict[int, Value] = {}
        last: dict[Value, Value] = {}
        ends = self._ends()
        if ends:
            last[Ref(counter.phi.id)] = counter.limit
        for phi, step in self._others():
            start = next(value for source, value in phi.incoming if source not in loop.blocks)
            make = _Maker(ids, ahead)
            by = make.polynomial(step)
            if ends:
                last[Ref(phi.id)] = make.moved(start, counter.limit, counter.initial, by)
            make = _Maker(ids, inside)
            values[phi.id] = make.moved(start, Ref(counter.phi.id), counter.initial, by)
        entered = function.by_name[before]
        entered = replace(entered, instrs=(*entered.instrs, *ahead))
        header = replace(header, instrs=(*inside, *header.instrs))
        made = with_blocks(function, (entered, header))
        behind = (one for one in made.blocks if one.name not in loop.blocks)
        changed = [map_values(one, lambda value: last.get(value, value)) for one in behind]
        return replaced(with_blocks(made, changed), values) if values or last else function

    def _ends(self) -> bool:
        """Whether the counter is its limit behind the loop."""
        loop, counter = self.loop, self.counter
        if [source for source, _ in loop.exits] != [loop.header]:
            return False
        order = Order(self.function)
        facts = order.facts(preheader_of(self.function, loop))
        ends = order.sum_of(counter.limit).less(order.sum_of(counter.initial))
        return order.is_proved(ends, facts)

    def _others(self) -> Iterator[tuple[Phi, Polynomial]]:
        """Phis to which each iteration adds a number from outside, and the number."""
        polynomials = Polynomials(self.function)
        for phi in self.function.by_name[self.loop.header].phis:
            step = _step(self.function, polynomials, self.loop, phi)
            if step is not None and phi.id != self.counter.phi.id:
                yield phi, step


@dataclass(frozen=True)
class _Maker:
    """Adds instructions on words to a list."""

    ids: FreshIds
    instrs: list[Instr]

    def made(self, op: Opcode, *operands: Value) -> Value:
        """What an operation gives."""
        self.instrs.append(Instr(self.ids(), op, Type.I32, operands))
        return Ref(self.instrs[-1].id)

    def moved(self, start: Value, count: Value, first: Value, by: Value) -> Value:
        """start + (count - first) * by."""
        count = count if first == Const(0) else self.made(Opcode.SUB, count, first)
        return self.made(Opcode.ADD, start, self.made(Opcode.MUL, count, by))

    def polynomial(self, polynomial: Polynomial) -> Value:
        """A polynomial as a value."""
        total: Value = Const(0)
        for monomial, factor in polynomial.terms.items():
            term: Value = Const(factor & WORD_MASK)
            for value in monomial:
                term = self.made(Opcode.MUL, value, term)
            total = term if total == Const(0) else self.made(Opcode.ADD, total, term)
        return total


def _step(function: Function, polynomials: Polynomials, loop: Loop, phi: Phi) -> Polynomial | None:
    """What each iteration adds to a phi, if that is made of values from outside."""
    if phi.type is not Type.I32 or len(phi.incoming) != len(("start", "again")):
        return None
    again = next(value for source, value in phi.incoming if source in loop.blocks)
    step = polynomials.of(again).plus(symbol(Ref(phi.id)), -1)
    found = (value for monomial in step.terms for value in monomial)
    inside = any(
        isinstance(value, Ref) and function.block_of[value.id] in loop.blocks for value in found
    )
    return None if inside else step
