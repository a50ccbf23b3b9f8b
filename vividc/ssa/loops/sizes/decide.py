"""Without what the order of integers decides: clamps, choices and branches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_BITS
from vividc.ssa.analysis.order import Order
from vividc.ssa.edit import replaced
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value, definition_of
from vividc.ssa.loops.sizes.exact import with_exact_sums
from vividc.ssa.rewrite.simplify import simplify

_SIGN: Final = Const(WORD_BITS - 1)
"""By so many bits an integer is shifted for what the higher word of one of 64 bits is."""


def decided(function: Function) -> Function:
    """The function without minima, maxima, selections and branches that are decided: in
    `A[i, :i + 1]` with i below the rows, the end is i + 1 without a clamp.
    """
    before = None
    while function is not before:
        before, function = function, _once(with_exact_sums(function))
    return function


def _once(function: Function) -> Function:
    order = Order(function)
    values = dict(_values(order))
    branches = {block.name: _branch(order, block) for block in function.blocks}
    blocks = tuple(
        replace(block, branch=replace(block.branch, cond=cond)) if cond is not None else block
        for block in function.blocks
        for cond in (branches[block.name],)
    )
    if not values and not any(branches.values()):
        return function
    return simplify(replaced(replace(function, blocks=blocks), values))


def _values(order: Order) -> Iterator[tuple[int, Value]]:
    """What instructions give, by id, where that is one of their operands."""
    for block in order.function.blocks:
        for instr in block.instrs:
            value = None
            if instr.op in (Opcode.SMIN, Opcode.SMAX):
                value = _extremum(order, instr, block.name)
            elif instr.op is Opcode.SELECT:
                value = _selected(order, instr, block.name)
            elif instr.op is Opcode.ASHR and instr.operands[1] == _SIGN:
                is_natural = order.at_most(Const(0), instr.operands[0], block.name) == ()
                value = Const(0) if is_natural else None
            elif instr.type is Type.PRED and instr.op not in (Opcode.AND, Opcode.OR, Opcode.XOR):
                truth = order.truth(Ref(instr.id), block.name)
                value = None if truth is None else Const(int(truth))
            if value is not None:
                yield instr.id, value


def _extremum(order: Order, instr: Instr, block: str) -> Value | None:
    left, right = instr.operands
    if instr.op is Opcode.SMAX:
        left, right = right, left
    if order.at_most(left, right, block) == ():
        return instr.operands[0]
    return instr.operands[1] if order.at_most(right, left, block) == () else None


def _selected(order: Order, instr: Instr, block: str) -> Value | None:
    """One of two values: the one that is chosen here, or that both are where the other is."""
    condition, *sides = instr.operands
    truth = order.truth(condition, block)
    if truth is not None:
        return sides[0] if truth else sides[1]
    if instr.type is not Type.I32:
        return None
    one, other = map(order.sum_of, sides)
    for truth, kept in ((False, sides[0]), (True, sides[1])):
        facts = order.facts(block)
        facts = (*facts, *order.implied(condition, truth, facts))
        if order.equal(one, other, facts) == ():
            return kept
    return None


def _branch(order: Order, block: Block) -> Value | None:
    """The truth of a block's branch."""
    condition = block.branch.cond
    made = definition_of(order.function, condition)
    if condition is None or not isinstance(made, Instr):
        return None
    truth = order.truth(condition, block.name)
    return None if truth is None else Const(int(truth))
