"""Random nests with what `nests` has not: floats, guards, steps, two lengths and their extremes,
indices from a length on, transposed elements, and elements that each iteration uses anew.
"""

from __future__ import annotations

import random

from tests.ssa.polyhedral.nests import Builder
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.machine.words import word_of
from vividc.ssa.ir import Branch, Const, Function, Input, Instr, Phi, Ref, Value, pitch_of

PARAMS = (
    Param("a", DType.I32, 1),
    Param("b", DType.I32, 2),
    Param("f", DType.F32, 1),
    Param("t", DType.I32, 1),
    Param("g", DType.I32, 1),
    Param("n", DType.I32, 0),
)
LENGTHS: tuple[Value, ...] = (Input("n"), Input("g.shape0"))
"""A number that may be anything, and one that is never negative."""
MOST = 9
"""They are no larger; then indices lie in their arrays."""
WIDTH = 32
"""Rows and columns of `b`; `a` and `f` have as many words as it, `t` as many as a row."""


_KINDS = ("load", "store", "update", "mix", "real", "real", "sum", "guard", "own", "transpose")
_REALS = (Opcode.FADD, Opcode.FSUB, Opcode.FMUL)


class _Wide(Builder):
    """The last of its scalars is a float."""

    def __init__(self, seed: int, often: float = 0.0) -> None:
        chance = random.Random(seed)
        self.often, self.fixed = often, random.Random(seed)
        scalars: list[Value] = [Const(3), Const(5), Const(word_of(0.5))]
        kinds = (Type.I32, Type.I32, Type.F32)
        super().__init__(chance, scalars=scalars, kinds=kinds, in_bytes=random.Random(seed))
        self.extremes: tuple[Value, ...] = tuple(
            self.emit(op, *LENGTHS) for op in (Opcode.SMIN, Opcode.SMAX)
        )

    def statement(self) -> None:
        """Something from or to memory, or arithmetic on a scalar."""
        if self.fixed.random() < self.often:
            self.in_place()
            return
        kind = self.chance.choice(_KINDS)
        if kind in ("real", "sum"):
            self.real(is_sum=kind == "sum")
        elif kind == "guard":
            self.guarded()
        elif kind == "own":
            self.own()
        elif kind == "transpose":
            self.transposed()
        else:
            self.whole(kind)

    def in_place(self) -> None:
        """One of few elements is loaded, stored, or updated, by loops at any depth."""
        place = Const(self.fixed.randrange(2))
        what = self.fixed.choice(("load", "store", "update"))
        value: Value = self.fixed.choice([*self.counters, self.scalars[0]])
        if what != "store":
            value = self.emit(Opcode.XOR, self.load("t", place, 0), value)
        if what != "load":
            self.store("t", place, value)
        else:
            self.scalars[1] = self.emit(Opcode.ADD, self.scalars[1], value)

    def whole(self, kind: str) -> None:
        """As in `nests`, of the integers."""
        self.plain(kind, self.chance.randrange(len(self.scalars) - 1))

    def real(self, *, is_sum: bool) -> None:
        """f[..] and the float that loops carry: one of them becomes what both make."""
        index, offset = self.subscript(most=2), 4 * self.chance.randint(0, 2)
        value = self.load("f", index, offset)
        self.scalars[-1] = self.emit(self.chance.choice(_REALS), self.scalars[-1], value)
        if not is_sum:
            self.store("f", self.subscript(most=2), self.scalars[-1])

    def guarded(self) -> None:
        """What memory decides: selected mostly, sometimes in a branch."""
        index = self.subscript(most=2)
        old = self.load("a", index, 0)
        test = self.emit(Opcode.ICMP_SLT, old, self.chance.choice(self.scalars[:-1]))
        if self.chance.random() < 0.9:
            new = self.emit(Opcode.ADD, old, self.chance.choice(self.counters))
            self.store("a", index, self.emit(Opcode.SELECT, test, new, old))
            return
        then, after = self.fresh("then"), self.fresh("joined")
        before = self.close(Branch(then, test, after))
        self.open(then)
        self.store("a", self.subscript(most=2), old)
        changed = self.emit(Opcode.ADD, self.scalars[0], Const(1))
        self.close(Branch(after))
        joined = self.new()
        self.open(after, (Phi(joined, Type.I32, ((before, self.scalars[0]), (then, changed))),))
        self.scalars[0] = Ref(joined)

    def own(self) -> None:
        """An element of `t` that is stored, and loaded again: a temporary of each iteration."""
        is_inner = self.chance.random() < 0.4
        place = self.counters[-1] if is_inner else Const(self.chance.randrange(2))
        which = self.chance.randrange(2)
        if self.chance.random() < 0.7:
            self.store("t", place, self.scalars[which])
        value = self.load("t", place, 0)
        self.scalars[1 - which] = self.emit(Opcode.XOR, self.scalars[1 - which], value)

    def transposed(self) -> None:
        """b[i, j] and b[j, i]."""
        one, other = (self.chance.choice(self.counters) for _ in "12")
        value = self.load("b", self.cell(one, other), 0)
        value = self.emit(Opcode.ADD, value, self.scalars[0])
        self.store("b", self.cell(other, one), value)

    def cell(self, row: Value, column: Value) -> Value:
        """The index of an element of `b`."""
        return self.emit(Opcode.ADD, self.emit(Opcode.MUL, row, pitch_of("b", 1)), column)

    def load(self, array: str, index: Value, offset: int) -> Value:
        kind = Type.F32 if array == "f" else Type.I32
        operands = (Input(f"&{array}"), index)
        self.instrs.append(Instr(self.new(), Opcode.LOAD, kind, operands, array, 2, offset))
        return Ref(self.ids)

    def store(self, array: str, index: Value, value: Value) -> None:
        operands = (Input(f"&{array}"), index, value)
        self.instrs.append(Instr(self.new(), Opcode.STORE, Type.NONE, operands, array, 2, 0))

    def element(self) -> tuple[str, Value, int, tuple[int | None, ...]]:
        """An element, perhaps of the part of `a` that begins at a length, perhaps before it."""
        array, index, offset, known = super().element()
        if array == "a" and self.chance.random() < 0.3:
            index = self.emit(Opcode.ADD, index, self.chance.choice(LENGTHS))
        if array == "a" and self.chance.random() < 0.2:
            index, offset = self.emit(Opcode.ADD, index, Const(2)), offset - 2
        return array, index, offset, known

    def bound(self) -> Value:
        """As in `nests`, or the other length, or the lesser or the greater of the two."""
        drawn = self.chance.random()
        if drawn < 0.15:
            return LENGTHS[1]
        if drawn < 0.25:
            return self.chance.choice(self.extremes)
        if drawn < 0.26 and self.counters:
            return self.emit(Opcode.SMIN, self.chance.choice(self.counters), LENGTHS[1])
        return super().bound()

    def least(self) -> Value:
        """Mostly 0: loops are seldom empty then."""
        return Const(0) if self.chance.random() < 0.6 else self.bound()

    def start(self, value: Value) -> Value:
        """Mostly the length that is never negative: what may be anything is refused."""
        is_any = value == LENGTHS[0] or value in self.extremes
        return LENGTHS[1] if is_any and self.chance.random() < 0.95 else value

    def step(self) -> int:
        return self.chance.choice((2, 3)) if self.chance.random() < 0.03 else 1


def random_wide_nest(seed: int, often: float = 0.0) -> Function:
    """A function of `PARAMS`; where it leaves its arrays it is no program. `often`: how many of its
    statements access an element at a fixed place.
    """
    builder = _Wide(seed, often)
    builder.in_branches = random.Random(seed)
    builder.body(0)
    for place, value in enumerate(builder.scalars):
        array = "f" if place + 1 == len(builder.scalars) else "a"
        builder.store(array, Const(WIDTH * WIDTH - 1 - place), value)
    builder.close(Branch())
    return Function("nest", PARAMS, tuple(builder.blocks))
