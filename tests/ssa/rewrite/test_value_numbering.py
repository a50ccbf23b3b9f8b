"""Equal operations of one block merge; those of different blocks, and accesses, stay."""

from __future__ import annotations

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.params import DType as D
from vividc.machine.params import Param
from vividc.ssa.ir import Block, Branch, Const, Function, Input, Instr, Ref, Value
from vividc.ssa.rewrite.value_numbering import merge_equal

A, B = Input("a"), Input("b")


def instr(ident: int, op: Opcode, *operands: Value) -> Instr:
    return Instr(ident, op, Type.I32, operands)


def function(*blocks: Block) -> Function:
    return Function("f", (Param("a", D.I32), Param("b", D.I32)), blocks, D.I32, "f.py")


def test_equal_operations_merge_in_chains() -> None:
    instrs = (
        instr(0, Opcode.ADD, A, B),
        instr(1, Opcode.ADD, B, A),
        instr(2, Opcode.SUB, Ref(1), A),
        instr(3, Opcode.SUB, Ref(0), A),
        instr(4, Opcode.SUB, A, Ref(0)),
    )
    merged = merge_equal(function(Block("b0", (), instrs, Branch(value=Ref(3)))))
    assert [i.id for i in merged.blocks[0].instrs] == [0, 2, 4]
    assert merged.blocks[0].instrs[1].operands == (Ref(0), A)
    assert merged.blocks[0].branch.value == Ref(2)


def test_blocks_and_other_operands_stay_apart() -> None:
    first = Block("b0", (), (instr(0, Opcode.ADD, A, B),), Branch("b1"))
    second = Block("b1", (), (instr(1, Opcode.ADD, A, B),), Branch(value=Ref(1)))
    third = (
        instr(2, Opcode.SUB, A, B),
        instr(3, Opcode.SUB, B, A),
        instr(4, Opcode.SUB, A, Const(1)),
    )
    source = function(first, second, Block("b2", (), third, Branch(value=Ref(2))))
    assert merge_equal(source) is source
