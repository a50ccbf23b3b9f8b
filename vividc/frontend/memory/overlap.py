"""Copies between slices: numba asks at run time whether they overlap; here the arrays decide.

Slices of one array are taken to overlap, and numba copies through an array of its own.
"""

from __future__ import annotations

from dataclasses import replace

from vividc.frontend.llvm.calls import OVERLAP
from vividc.frontend.llvm.ir import (
    Global,
    Int,
    Local,
    Op,
    Operand,
    WideFunction,
    WidePhi,
    substitute,
    type_of,
)
from vividc.frontend.ranges.fold import fold_by_ranges
from vividc.frontend.ranges.ranges import Ranges


def fold_overlaps(function: WideFunction) -> WideFunction:
    """Answer the questions whether two slices may overlap: slices of different arrays do not."""
    asked = {op.name: op for block in function.blocks for op in block.ops if op.pred == OVERLAP}
    if not asked:
        return function
    answers: dict[str, Operand] = {}
    for op in asked.values():
        one, other = (_arrays(function, arg) for arg in op.args)
        answers[op.name] = Int(int(not one or not other or bool(one & other)))
    blocks = tuple(
        replace(block, ops=tuple(op for op in block.ops if op.name not in asked))
        for block in function.blocks
    )
    function = substitute(replace(function, blocks=blocks), answers)
    return fold_by_ranges(function, Ranges(function, {}))


def _arrays(function: WideFunction, address: Operand) -> set[str]:
    """Parameters that an address is computed from; {""} stands for what is not known."""
    found: set[str] = set()
    seen: set[str] = set()
    pending = [address]
    while pending:
        operand = pending.pop()
        if isinstance(operand, Global):
            found.add(operand.name)
        if not isinstance(operand, Local) or operand.name in seen:
            continue
        seen.add(operand.name)
        definition = function.definitions.get(operand.name)
        if isinstance(definition, WidePhi):
            pending.extend(value for _, value in definition.incoming)
        elif isinstance(definition, Op) and definition.op == "call":
            found.add(operand.name)  # an array that the kernel makes
        elif isinstance(definition, Op):
            pending.extend(definition.args)
        elif type_of(function, operand) == "ptr":
            found.add(operand.name)
    return found
