"""Random nests in SSA of sums of products of elements, some of them split into two loops where one
begins as the other ends, some in a scalar that is stored behind its loop.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from tests.ssa.polyhedral.nests import PARAMS, Builder
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.ir import Branch, Const, Function, Input, Instr, Ref, Value, pitch_of


@dataclass
class _Sums(Builder):
    scalars: list[Value] = field(default_factory=list)
    kinds: tuple[Type, ...] = ()
    planned: list[Value] = field(default_factory=list)
    """Bounds of the next loops."""

    def body(self, depth: int) -> None:
        """Statements and loops, some of which go on in a second loop."""
        for _ in range(self.chance.randint(2, 3) if depth < 2 else 1):
            if depth and (depth == 3 or self.chance.random() < 0.5):
                self.statement()
            elif depth and not self.scalars and self.chance.random() < 0.4:
                self.total(depth)
            elif self.chance.random() < 0.5:
                self.split(depth)
            else:
                self.loop(depth)

    def split(self, depth: int) -> None:
        """A loop up to somewhere, and one from there, that do the same."""
        seed, limit = self.chance.random(), Input("n")
        middle = self.chance.choice([*self.counters, Const(2)])
        counters = list(self.counters)
        for bounds in ((Const(0), middle), (middle, limit)):
            self.chance = random.Random(seed)
            self.counters = list(counters)
            self.planned = list(reversed(bounds))
            self.loop(depth)

    def total(self, depth: int) -> None:
        """A sum in a scalar, from the element that it ends in or another one."""
        base, (target, offset) = Input("&b"), self.place()
        first, more = (target, offset) if self.chance.random() < 0.6 else self.place()
        self.kinds = (Type.I32,)
        self.scalars = [self.access(Opcode.LOAD, Type.I32, (base, first), more)]
        self.loop(depth)
        self.access(Opcode.STORE, Type.NONE, (base, target, self.scalars.pop()), offset)
        self.kinds = ()

    def bound(self) -> Value:
        if not self.planned and self.chance.random() < 0.8:
            ends = ([Input("n"), *self.counters], [Const(0), Const(0), *self.counters])
            self.planned = [self.chance.choice(end) for end in ends]
        return self.planned.pop() if self.planned else super().bound()

    def statement(self) -> None:
        """An element, or the sum around, becomes less a product of others; or an element three
        times itself and one of another.
        """
        base, factor = Input("&b"), self.chance.choice([0, 3])
        target, offset = self.place()
        is_sum = bool(self.scalars) and self.chance.random() < 0.7
        own = (
            self.scalars[0]
            if is_sum
            else self.access(Opcode.LOAD, Type.I32, (base, target), offset)
        )
        other, more = self.place()
        first = self.access(Opcode.LOAD, Type.I32, (base, other), more)
        if factor:
            value = self.emit(Opcode.MUL, own, Const(factor))
            value = self.emit(Opcode.ADD, value, first)
        else:
            other, more = self.place()
            second = self.access(Opcode.LOAD, Type.I32, (base, other), more)
            value = self.emit(Opcode.SUB, own, self.emit(Opcode.MUL, first, second))
        if is_sum:
            self.scalars = [value]
            return
        self.access(Opcode.STORE, Type.NONE, (base, target, value), offset)

    def place(self) -> tuple[Value, int]:
        """An element of `b` by counters of two loops, or of one twice."""
        row, column = (self.chance.choice(self.counters) for _ in "12")
        index = self.emit(Opcode.ADD, self.emit(Opcode.MUL, row, pitch_of("b", 1)), column)
        return index, 4 * self.chance.choice([0, 0, 0, 1])

    def access(self, op: Opcode, kind: Type, operands: tuple[Value, ...], offset: int) -> Value:
        self.instrs.append(Instr(self.new(), op, kind, operands, "b", 2, offset))
        return Ref(self.ids)


def random_sums(seed: int) -> Function:
    """A function of arrays `a` and `b` and a number `n` from 0 to 5."""
    builder = _Sums(random.Random(seed))
    builder.loop(0)
    builder.close(Branch())
    return Function("nest", PARAMS, tuple(builder.blocks))
