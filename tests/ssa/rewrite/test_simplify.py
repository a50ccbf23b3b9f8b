"""Simplified functions mean what they meant, and decided control flow is gone."""

from __future__ import annotations

from hypothesis import given, settings

from tests.dfg.cut.test_build import meaning, memory_after
from tests.dfg.programs import For, Load, Store, lower, programs
from vividc.dfg.cut.build import build_kernel
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.check import check_function
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref
from vividc.ssa.rewrite.simplify import simplify


@settings(max_examples=100, deadline=None, derandomize=True)
@given(programs())
def test_simplified_programs_mean_the_same(program: tuple[object, ...]) -> None:
    function = simplify(lower(program))
    assert check_function(function) == []
    assert simplify(function) is function
    assert memory_after(build_kernel(function)) == meaning(program)


def test_a_branch_on_constants_leaves_one_block() -> None:
    test = Instr(0, Opcode.ICMP_SLT, Type.PRED, (Const(2), Const(5)))
    phi = Phi(1, Type.I32, (("yes", Const(10)), ("no", Const(20))))
    store = Instr(2, Opcode.STORE, Type.NONE, (Input("&a"), Const(0), Ref(1)), "a", 2)
    blocks = (
        Block("entry", (), (test,), Branch("yes", Ref(0), "no")),
        Block("yes", (), (), Branch("join")),
        Block("no", (), (), Branch("join")),
        Block("join", (phi,), (store,), Branch()),
    )
    (block,) = simplify(Function("f", (), blocks)).blocks
    assert [instr.operands[2] for instr in block.instrs] == [Const(10)]


def test_loops_stay() -> None:
    function = lower((For(0, 0, 4, (Load(1, 0), Store(1, 0))),))
    assert len(simplify(function).blocks) < len(function.blocks)
    assert memory_after(build_kernel(simplify(function))) == memory_after(build_kernel(function))
