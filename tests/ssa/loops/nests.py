"""Random nests of two counted loops over one array with affine accesses, as control-flow graphs."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref, Value

WORDS = 64


@dataclass(frozen=True)
class Step:
    """total += a[index] ("load"), a[index] = total ("store"), or total = 3 * total + 1 ("mix").

    index = outer * i + inner * j + constant.
    """

    kind: str
    outer: int = 0
    inner: int = 0
    constant: int = 0


@dataclass(frozen=True)
class NestProgram:
    """for i in range(outer): total = i (or goes on); before; for j in range(inner): body; after."""

    outer: int
    inner: int
    before: tuple[Step, ...]
    body: tuple[Step, ...]
    after: tuple[Step, ...]
    fresh: bool


def steps() -> st.SearchStrategy[tuple[Step, ...]]:
    """Up to two steps; every index lies in the array."""
    small = st.integers(0, 4)
    step = st.builds(
        Step, st.sampled_from(["load", "store", "mix"]), small, small, st.integers(0, 20)
    )
    return st.lists(step, max_size=2).map(tuple)


def nest_programs() -> st.SearchStrategy[NestProgram]:
    """Nests of up to six by five iterations."""
    return st.builds(
        NestProgram,
        st.integers(0, 6),
        st.integers(0, 5),
        steps(),
        steps(),
        steps(),
        st.booleans() | st.just(True),
    )


@dataclass
class _Emitter:
    free: int = 0
    instrs: list[Instr] = field(default_factory=list)

    def new(self) -> int:
        self.free += 1
        return self.free - 1

    def emit(self, op: Opcode, result: Type, *operands: Value) -> Ref:
        memory = op in (Opcode.LOAD, Opcode.STORE)
        name, shift = ("a", 2) if memory else ("", 0)
        self.instrs.append(Instr(self.new(), op, result, operands, name, shift))
        return Ref(self.instrs[-1].id)

    def take(self) -> tuple[Instr, ...]:
        taken, self.instrs = tuple(self.instrs), []
        return taken

    def index(self, step: Step, i: Value, j: Value) -> Value:
        scaled = [
            self.emit(Opcode.MUL, Type.I32, value, Const(factor))
            for value, factor in ((i, step.outer), (j, step.inner))
        ]
        total = self.emit(Opcode.ADD, Type.I32, *scaled)
        return self.emit(Opcode.ADD, Type.I32, total, Const(step.constant))

    def run(self, body: tuple[Step, ...], i: Value, j: Value, total: Value) -> Value:
        for step in body:
            if step.kind == "mix":
                total = self.emit(Opcode.MUL, Type.I32, total, Const(3))
                total = self.emit(Opcode.ADD, Type.I32, total, Const(1))
                continue
            address = self.index(step, i, j)
            if step.kind == "store":
                self.emit(Opcode.STORE, Type.NONE, Input("&a"), address, total)
            else:
                word = self.emit(Opcode.LOAD, Type.I32, Input("&a"), address)
                total = self.emit(Opcode.ADD, Type.I32, total, word)
        return total


def lower_nest(program: NestProgram) -> Function:
    """The nest as blocks; the total is stored to a[0] at the end."""
    e = _Emitter()
    i, j, total, inner_total = (Ref(e.new()) for _ in range(4))
    zero = Const(0)
    test = e.emit(Opcode.ICMP_SLT, Type.PRED, i, Const(program.outer))
    header = e.take()
    started = e.run(program.before, i, zero, i if program.fresh else total)
    before = e.take()
    inner_test = e.emit(Opcode.ICMP_SLT, Type.PRED, j, Const(program.inner))
    inner_header = e.take()
    carried = e.run(program.body, i, j, inner_total)
    next_j = e.emit(Opcode.ADD, Type.I32, j, Const(1))
    body = e.take()
    ended = e.run(program.after, i, zero, inner_total)
    next_i = e.emit(Opcode.ADD, Type.I32, i, Const(1))
    after = e.take()
    e.emit(Opcode.STORE, Type.NONE, Input("&a"), zero, total)
    last = e.take()
    i32 = Type.I32
    outer_phis = (
        Phi(i.id, i32, (("entry", zero), ("after", next_i))),
        Phi(total.id, i32, (("entry", Const(5)), ("after", ended))),
    )
    inner_phis = (
        Phi(j.id, i32, (("before", zero), ("body", next_j))),
        Phi(inner_total.id, i32, (("before", started), ("body", carried))),
    )
    blocks = (
        Block("entry", (), (), Branch("outer")),
        Block("outer", outer_phis, header, Branch("before", test, "end")),
        Block("before", (), before, Branch("inner")),
        Block("inner", inner_phis, inner_header, Branch("body", inner_test, "after")),
        Block("body", (), body, Branch("inner")),
        Block("after", (), after, Branch("outer")),
        Block("end", (), last, Branch()),
    )
    return Function("nest", (Param("a", DType.I32, 1),), blocks)


def nest_memory(function: Function) -> list[int]:
    """The array after interpreting the function's regions from 1, 8, 27, ..."""
    memory = (np.arange(1, WORDS + 1, dtype=np.uint32)) ** 3
    kernel = build_kernel(function)
    interpret(kernel, memory, {"&a": 0, "a.shape0": WORDS}, iteration_limit=10_000)
    return [int(word) for word in memory]
