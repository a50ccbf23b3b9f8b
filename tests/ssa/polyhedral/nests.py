"""Random affine nests in SSA: imperfect, triangular, descending, with scalars that loops carry, and
with a temporary that one loop fills and the next one reads.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Value, pitch_of

SIDE = 24
"""Rows and columns of `b`; `a` has as many words as it."""

TEMPORARY = 12
"""Words of the temporary `t`."""

_DEPTH = 3
PARAMS = (Param("a", DType.I32, 1), Param("b", DType.I32, 2), Param("n", DType.I32, 0))

DTYPES = (DType.I32, DType.U8, DType.I8, DType.U16, DType.I16)
"""Of the elements of `a` and `b`."""


@dataclass
class Builder:
    """Writes blocks; `counters` are the values of the loops around, `scalars` what they carry."""

    chance: random.Random
    blocks: list[Block] = field(default_factory=list)
    name: str = "entry"
    phis: tuple[Phi, ...] = ()
    instrs: list[Instr] = field(default_factory=list)
    counters: list[Value] = field(default_factory=list)
    scalars: list[Value] = field(default_factory=lambda: [Const(3), Const(5)])
    kinds: tuple[Type, ...] = (Type.I32, Type.I32)
    """Of the scalars."""
    ids: int = 0
    names: int = 0
    in_bytes: random.Random = field(default_factory=lambda: random.Random(0))
    """Decides whether indices count bytes, as of rows that LLVM knows."""
    in_branches: random.Random = field(default_factory=lambda: random.Random(0))
    """Decides what runs under a test of counters and bounds."""
    temporaries: bool = False
    dtype: DType = DType.I32

    def new(self) -> int:
        self.ids += 1
        return self.ids

    def emit(self, op: Opcode, *operands: Value, exact: bool = False) -> Value:
        kind = Type.F32 if op.value.startswith("f") else Type.I32
        kind = Type.PRED if "cmp" in op.value else kind
        self.instrs.append(Instr(self.new(), op, kind, operands, exact=exact))
        return Ref(self.ids)

    def close(self, branch: Branch) -> str:
        self.blocks.append(Block(self.name, self.phis, tuple(self.instrs), branch))
        return self.name

    def open(self, name: str, phis: tuple[Phi, ...] = ()) -> None:
        self.name, self.phis, self.instrs = name, phis, []

    def fresh(self, stem: str) -> str:
        self.names += 1
        return f"{stem}{self.names}"

    def body(self, depth: int) -> None:
        """Statements, and loops in between."""
        for _ in range(self.chance.randint(1, 3 if depth else 2)):
            if depth < _DEPTH and self.chance.random() < (0.9 if not depth else 0.5):
                self.loop(depth)
            elif depth and self.in_branches.random() < 0.12:
                self.branch(depth)
            elif depth:
                self.statement()
            if depth and self.temporaries and depth < _DEPTH and self.chance.random() < 0.5:
                self.temporary(depth)

    def temporary(self, depth: int) -> None:
        """A loop that fills `t`, and one that reads it: as many elements, or others."""
        ends = Const(0), self.chance.choice([Input("n"), Const(3), self.counters[0]])
        self.loop(depth, self.filling, ends)
        if self.chance.random() < 0.3:
            self.statement()
        self.loop(depth, self.reading, ends if self.chance.random() < 0.8 else None)

    def filling(self) -> None:
        """t[p] = what is computed, perhaps of p."""
        value = self.emit(Opcode.ADD, self.scalars[0], self.chance.choice(self.counters))
        if self.chance.random() < 0.1:
            value = self.emit(Opcode.ADD, value, self.of_temporary())
        offset = 4 * (self.chance.random() < 0.1)
        operands = (Input("&t"), self.counters[-1], value)
        self.instrs.append(Instr(self.new(), Opcode.STORE, Type.NONE, operands, "t", 2, offset))

    def reading(self) -> None:
        """An element of b, in the row of a loop around, or a scalar takes t[p]."""
        value = self.emit(Opcode.ADD, self.of_temporary(), self.scalars[0])
        if self.chance.random() < 0.1:
            self.scalars[1] = value
            return
        counter = self.chance.choice(self.counters[:-1])
        row = self.emit(Opcode.MUL, counter, pitch_of("b", 1))
        index = self.emit(Opcode.ADD, row, self.counters[-1])
        operands = (Input("&b"), index, value)
        self.instrs.append(Instr(self.new(), Opcode.STORE, Type.NONE, operands, "b", 2, 0))

    def of_temporary(self) -> Value:
        """t[p], or an element near it."""
        offset = 4 * (self.chance.random() < 0.1)
        operands = (Input("&t"), self.counters[-1])
        load = Instr(self.new(), Opcode.LOAD, Type.I32, operands, "t", 2, offset)
        self.instrs.append(load)
        return Ref(load.id)

    def branch(self, depth: int) -> None:
        """Statements and loops under a test, and others under its opposite; what they leave in
        scalars is forgotten.
        """
        choose = self.in_branches.choice
        limit = choose([*self.counters, *map(Const, range(6)), Input("n")])
        sides = self.in_branches.sample([choose(self.counters), limit], 2)
        op = choose([Opcode.ICMP_SLT, Opcode.ICMP_SLE, Opcode.ICMP_EQ])
        if choose([True, False]):
            sides[0] = self.emit(Opcode.ADD, sides[0], Const(1), exact=True)
        test, kept = self.emit(op, *sides), list(self.scalars)
        then, after = self.fresh("then"), self.fresh("joined")
        other = after if op is Opcode.ICMP_EQ else choose([after, self.fresh("else")])
        self.close(Branch(then, test, other))
        for arm in (then, other):
            if arm != after:
                self.open(arm)
                self.body(depth)
                self.statement()
                self.close(Branch(after))
                self.scalars = list(kept)
        self.open(after)

    def statement(self) -> None:
        """A load, a store, or arithmetic on a scalar."""
        which = self.chance.randrange(len(self.scalars))
        kind = self.chance.choice(["load", "store", "update", "mix"])
        if self.temporaries and self.chance.random() < 0.9:
            kind = "store"  # loops that carry scalars are not jammed
        self.plain(kind, which)

    def plain(self, kind: str, which: int) -> None:
        """A statement of this kind, of one of the scalars."""
        if kind == "mix":
            value = self.emit(Opcode.MUL, self.scalars[which], Const(5))
            self.scalars[which] = self.emit(Opcode.ADD, value, self.chance.choice(self.counters))
            return
        array, index, offset, subscript = self.element()
        base, width = Input(f"&{array}"), self.dtype.size_bytes
        offset, shift = offset * width, width.bit_length() - 1
        if not subscript and self.in_bytes.random() < 0.2:
            index, shift = self.emit(Opcode.MUL, index, Const(width)), 0
        if kind in ("load", "update"):
            signed = self.dtype.is_signed and self.dtype is not DType.I32
            load = Instr(self.new(), Opcode.LOAD, Type.I32, (base, index), array, shift, offset)
            load = replace(load, subscript=subscript, width=width, signed=signed)
            self.instrs.append(load)
            self.scalars[which] = self.emit(Opcode.ADD, self.scalars[which], Ref(load.id))
        if kind in ("store", "update"):
            operands = (base, index, self.scalars[which])
            store = Instr(self.new(), Opcode.STORE, Type.NONE, operands, array, shift, offset)
            self.instrs.append(replace(store, subscript=subscript, width=width))

    def element(self) -> tuple[str, Value, int, tuple[int | None, ...]]:
        """An array, the index of an element of it, further elements, constant subscripts."""
        offset = self.chance.randint(0, 2)
        if self.chance.random() < 0.5:
            return "a", self.subscript(most=2), offset, ()
        row = self.subscript(most=1)
        known = (row.word, None) if isinstance(row, Const) else ()
        row = self.emit(Opcode.MUL, row, pitch_of("b", 1))
        return "b", self.emit(Opcode.ADD, row, self.subscript(most=1)), offset, known

    def subscript(self, most: int) -> Value:
        """A sum of counters, or one that falls, and a constant."""
        total: Value = Const(self.chance.randint(0, 3))
        for counter in self.chance.sample(self.counters, min(2, len(self.counters))):
            factor = self.chance.randint(0, most)
            if factor:
                scaled = self.emit(Opcode.MUL, counter, Const(factor))
                total = self.emit(Opcode.ADD, total, scaled)
        if self.chance.random() < 0.2:
            total = self.emit(Opcode.SUB, Const(SIDE - 4), self.chance.choice(self.counters))
        return total

    def bound(self) -> Value:
        """A constant, a parameter, a counter, or one beside it."""
        choice = self.chance.randrange(4)
        if choice == 0 or (choice > 1 and not self.counters):
            return Const(self.chance.randint(0, 5))
        if choice == 1:
            return Input("n")
        counter = self.chance.choice(self.counters)
        if self.chance.random() < 0.1:
            return self.emit(Opcode.MUL, counter, Const(1 << 30))
        if choice == 2:
            return counter
        return self.emit(Opcode.ADD, counter, Const(1), exact=True)

    def stencil(self, depth: int) -> None:
        """Loops around a few means of neighbours, each stored in `b` or in `a`."""
        if depth < _DEPTH and (depth < _DEPTH - 1 or self.chance.random() < 0.5):
            for _ in range(self.chance.choice([1, 1, 2])):
                self.loop(depth, lambda: self.stencil(depth + 1))
            return
        for _ in range(self.chance.choice([1, 1, 2])):
            total = self.scalars[0]
            for _ in range(self.chance.randint(2, 4)):
                load = self.neighbour(Opcode.LOAD)
                total = self.emit(self.chance.choice([Opcode.ADD, Opcode.SUB]), total, load)
            self.neighbour(Opcode.STORE, total)
            self.scalars[1] = self.chance.choice([self.scalars[1], total])

    def neighbour(self, op: Opcode, *stored: Value) -> Value:
        """An access of an element near the counters."""
        offset, inner = self.chance.randint(0, 2), self.counters[-1]
        array, index = "a", inner
        if self.chance.random() < 0.7:
            others = [Const(2), *self.counters[:-1]]
            row = self.emit(Opcode.ADD, others[-1], Const(self.chance.randint(0, 2)))
            row, column = (inner, row) if self.chance.random() < 0.2 else (row, inner)
            row = self.emit(Opcode.MUL, row, pitch_of("b", 1))
            array, index = "b", self.emit(Opcode.ADD, row, column)
        width, kind = self.dtype.size_bytes, Type.NONE if stored else Type.I32
        operands, shift = (Input(f"&{array}"), index, *stored), width.bit_length() - 1
        made = Instr(self.new(), op, kind, operands, array, shift, offset * width)
        signed = not stored and self.dtype.is_signed and self.dtype is not DType.I32
        self.instrs.append(replace(made, width=width, signed=signed))
        return Ref(made.id)

    def least(self) -> Value:
        """The lower bound of a loop."""
        return self.bound()

    def start(self, value: Value) -> Value:
        """Where a loop starts that is wished to start here."""
        return value

    def step(self) -> int:
        """By which a loop counts."""
        return 1

    def loop(
        self,
        depth: int,
        inside: Callable[[], None] | None = None,
        ends: tuple[Value, Value] | None = None,
    ) -> None:
        """for x in range(first, limit), upwards or downwards, up to the limit or below it."""
        first, limit = ends or (self.least(), self.bound())
        by = self.step()
        if first == Input("n") and self.chance.random() < 0.7:
            first = Const(0)  # a start that may be anything is refused
        often = 0.0 if ends else 0.05 if self.temporaries else 0.25
        down, inclusive = self.chance.random() < often, self.chance.random() < often
        if down:
            first, limit = limit, first
        first = self.start(first)
        before, header = self.close_into("header")
        counter, carried = self.new(), [self.new() for _ in self.scalars]
        entered = list(self.scalars)
        self.open(header)
        ends = (limit, Ref(counter)) if down else (Ref(counter), limit)
        test = self.emit(Opcode.ICMP_SLE if inclusive else Opcode.ICMP_SLT, *ends)
        head, body, after = tuple(self.instrs), self.fresh("body"), self.fresh("after")
        place = len(self.blocks)
        self.counters.append(Ref(counter))
        self.scalars = [Ref(ident) for ident in carried]
        self.open(body)
        if inside is None:
            self.body(depth + 1)
        else:
            inside()
        step = Const((-by if down else by) & WORD_MASK)
        following = self.emit(Opcode.ADD, Ref(counter), step, exact=True)
        latch = self.close(Branch(header))
        phis = [Phi(counter, Type.I32, ((before, first), (latch, following)))]
        for ident, kind, old, new in zip(carried, self.kinds, entered, self.scalars, strict=True):
            phis.append(Phi(ident, kind, ((before, old), (latch, new))))
        self.blocks.insert(place, Block(header, tuple(phis), head, Branch(body, test, after)))
        self.counters.pop()
        self.scalars = [Ref(ident) for ident in carried]
        self.open(after)

    def close_into(self, stem: str) -> tuple[str, str]:
        name = self.fresh(stem)
        return self.close(Branch(name)), name


def with_known(function: Function, n: int) -> Function:
    """The function for one `n` only, and for the shape of `b` that `arguments` gives."""
    known = {"b": (SIDE, SIDE), "n": (n,)}
    params = tuple(replace(p, known=known.get(p.name, ())) for p in function.params)
    value = Const(n & WORD_MASK)
    return settled(replace(function, params=params), value)


def settled(function: Function, n: Const) -> Function:
    """The function with a constant for `n`, as the frontend leaves it."""

    def of(value: Value) -> Value:
        return n if value == Input("n") else value

    def phi_of(phi: Phi) -> Phi:
        return replace(phi, incoming=tuple((source, of(v)) for source, v in phi.incoming))

    blocks = (
        replace(
            block,
            phis=tuple(map(phi_of, block.phis)),
            instrs=tuple(replace(i, operands=tuple(map(of, i.operands))) for i in block.instrs),
        )
        for block in function.blocks
    )
    return replace(function, blocks=tuple(blocks))


def random_nest(seed: int, dtype: DType = DType.I32, *, temporaries: bool = False) -> Function:
    """A function of arrays `a` and `b` and a number `n` from 0 to 5; indices lie in the arrays.
    With `temporaries`: of an array `t` too, behind `n`.
    """
    chances = (random.Random(seed), random.Random(seed))
    builder = Builder(chances[0], in_bytes=chances[1], temporaries=temporaries, dtype=dtype)
    builder.in_branches = random.Random(seed)
    builder.body(0)
    return _ended(builder)


def _ended(builder: Builder) -> Function:
    """The function, which stores what its loops carry."""
    for place, value in enumerate(builder.scalars):
        operands = (Input("&a"), Const(SIDE * SIDE - 1 - place), value)
        width = builder.dtype.size_bytes
        store = Instr(builder.new(), Opcode.STORE, Type.NONE, operands, "a", width.bit_length() - 1)
        builder.instrs.append(replace(store, width=width))
    builder.close(Branch())
    more = (Param("t", DType.I32, 1),) if builder.temporaries else ()
    params = tuple(replace(p, dtype=builder.dtype) if p.ndim else p for p in (*PARAMS, *more))
    return Function("nest", params, tuple(builder.blocks))


def random_stencil(seed: int, dtype: DType = DType.I32) -> Function:
    """A function as of `random_nest` whose loops store sums of neighbours."""
    builder = Builder(random.Random(f"stencil {seed}"), dtype=dtype)
    builder.stencil(0)
    return _ended(builder)


def arguments(function: Function, seed: int, n: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Arrays with small numbers."""
    numbers = np.random.default_rng(seed)
    dtype = function.params[0].dtype.value
    a = numbers.integers(-50, 50, SIDE * SIDE, dtype=np.int32).astype(dtype)
    return a, numbers.integers(-50, 50, (SIDE, SIDE), dtype=np.int32).astype(dtype), n


def temporary(function: Function) -> np.ndarray:
    """What `t` holds at first."""
    return np.arange(100, 100 + TEMPORARY).astype(function.params[0].dtype.value)
