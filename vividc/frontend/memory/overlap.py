"""Copies between slices: numba asks at run time whether they overlap; here the arrays decide.

Slices of one array are taken to overlap, and numba copies through an array of its own.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.frontend.llvm.calls import OVERLAP
from vividc.frontend.ranges.fold import fold_by_ranges
from vividc.ssa.edit import substitute
from vividc.ssa.ir import Function, Global, Instr, Int, Key, Named, Phi, Value, type_of


def fold_overlaps(function: Function) -> Function:
    """Answer the questions whether two slices may overlap: slices of different arrays do not."""
    asked = {op.id: op for block in function.blocks for op in block.instrs if op.pred == OVERLAP}
    if not asked:
        return function
    answers: dict[int, Value] = {}
    for op in asked.values():
        one, other = (_arrays(function, arg) for arg in op.operands)
        answers[op.id] = Int(int(not one or not other or bool(one & other)))
    blocks = tuple(
        replace(block, instrs=tuple(op for op in block.instrs if op.id not in asked))
        for block in function.blocks
    )
    function = substitute(replace(function, blocks=blocks), answers)
    return fold_by_ranges(function)


def _arrays(function: Function, address: Value) -> set[Key]:
    """Parameters that an address is computed from; {""} stands for what is not known."""
    bases: set[Key] = set()
    seen: set[Key] = set()
    pending = [address]
    while pending:
        operand = pending.pop()
        if isinstance(operand, Global):
            bases.add(operand.name)
        if not isinstance(operand, Named) or operand.key in seen:
            continue
        seen.add(operand.key)
        definition = function.definitions.get(operand.key)
        if isinstance(definition, Phi):
            pending.extend(value for _, value in definition.incoming)
        elif isinstance(definition, Instr) and definition.op == "call":
            bases.add(operand.key)  # an array that the kernel makes
        elif isinstance(definition, Instr):
            pending.extend(definition.operands)
        elif type_of(function, operand) == "ptr":
            bases.add(operand.key)
    return bases
