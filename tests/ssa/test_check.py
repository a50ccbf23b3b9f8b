"""Each invariant of a CFG, broken alone, is reported."""

from __future__ import annotations

from dataclasses import replace

import pytest

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType, Param
from vividc.ssa.check import check_function
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Phi, Ref

LOOP = Function(
    "count",
    (Param("n", DType.I32),),
    (
        Block("entry", (), (), Branch("head")),
        Block(
            "head",
            (Phi(0, Type.I32, (("entry", Const(0)), ("body", Ref(2)))),),
            (Instr(1, Opcode.ICMP_SLT, Type.PRED, (Ref(0), Input("n"))),),
            Branch("body", Ref(1), "exit"),
        ),
        Block(
            "body",
            (),
            (Instr(2, Opcode.ADD, Type.I32, (Ref(0), Const(1))),),
            Branch("head"),
        ),
        Block("exit", (), (), Branch(value=Ref(0))),
    ),
    DType.I32,
)


def edited(name: str, **changes: object) -> Function:
    blocks = tuple(replace(b, **changes) if b.name == name else b for b in LOOP.blocks)
    return replace(LOOP, blocks=blocks)


def test_a_well_formed_function_has_no_problem() -> None:
    assert check_function(LOOP) == []


ADD = Instr(2, Opcode.ADD, Type.I32, (Ref(0), Const(1)))
PHI = LOOP.blocks[1].phis[0]
LOAD = Instr(2, Opcode.LOAD, Type.I32, (Input("&x"), Ref(0)), array="x")


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (replace(LOOP, blocks=()), "there is no block"),
        (replace(LOOP, blocks=(*LOOP.blocks, LOOP.blocks[3])), "2 blocks are named exit"),
        (edited("exit", instrs=(ADD,)), "2 definitions have id 2"),
        (edited("body", branch=Branch("nowhere")), "branches to nowhere"),
        (edited("head", branch=Branch("body", Ref(1))), "fewer than two blocks"),
        (edited("body", branch=Branch("head", value=Ref(2))), "jumps and returns"),
        (edited("body", instrs=(replace(ADD, operands=(Ref(0),)),)), "1 operands instead of 2"),
        (edited("body", instrs=(replace(ADD, op=Opcode.IV, operands=()),)), "is no instruction"),
        (edited("body", instrs=(replace(LOAD, array=""),)), "names no array"),
        (edited("body", instrs=(replace(LOAD, width=3),)), "has a width of 3 bytes"),
        (edited("body", instrs=(replace(ADD, width=1),)), "has a width of 1 bytes"),
        (edited("body", instrs=(replace(LOAD, signed=True),)), "is signed and no load"),
        (edited("body", instrs=(replace(ADD, operands=(Ref(0), Const(-1))),)), "is not a word: -1"),
        (edited("head", phis=(replace(PHI, incoming=PHI.incoming[:1]),)), "does not list"),
        (edited("head", branch=Branch("exit")), "body cannot be reached"),
        (edited("body", branch=Branch("entry")), "the entry entry has predecessors"),
        (edited("body", instrs=(replace(ADD, operands=(Ref(2), Const(1))),)), "before its def"),
        (edited("exit", branch=Branch(value=Ref(2))), "the branch of exit reads"),
        (
            edited("head", phis=(replace(PHI, incoming=(("entry", Ref(2)), ("body", Ref(2)))),)),
            "where it is not defined",
        ),
    ],
)
def test_a_broken_function_is_reported(broken: Function, problem: str) -> None:
    assert any(problem in text for text in check_function(broken))


def test_a_load_and_a_store_count_their_base() -> None:
    store = Instr(2, Opcode.STORE, Type.NONE, (Input("&x"), Ref(0), Const(1)), array="x")
    phi = replace(PHI, incoming=(("entry", Const(0)), ("body", Const(1))))
    for access in (LOAD, store):
        function = edited("body", instrs=(access,))
        blocks = tuple(replace(b, phis=(phi,)) if b.phis else b for b in function.blocks)
        assert check_function(replace(function, blocks=blocks)) == []
