"""Simplification of a function after control flow was copied or redirected.

Constants are folded, branches on constants become jumps, unreachable blocks, trivial phis and
results that nobody reads go, and straight chains of blocks become one block.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import replace
from operator import is_

from vividc.host import time_limit
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.ssa.analysis.constants import constant_value
from vividc.ssa.edit import replaced, resolved
from vividc.ssa.ir import Branch, Const, Function, Instr, Phi, Ref, Value, truth_of
from vividc.ssa.rewrite.blocks import merge_chains, only_value, remove_unreachable_blocks
from vividc.ssa.rewrite.dead import remove_unused


def simplify(function: Function) -> Function:
    """The same function with less control flow; the same object if nothing can be simplified."""
    before = None
    while function is not before:
        before = function
        function = fold_values(function)
        function = fold_branches(function)
        function = merge_chains(function)
    return remove_unused(function)


def fold_values(function: Function) -> Function:
    """Replaces operations on constants, `mov`s, decided selects and trivial phis by their values.

    Floating-point operations that have a table row fold as the array computes them; those that are
    expanded later do not fold, since an expansion need not give the same bits.
    """
    known: dict[int, Value] = {}
    flags = {phi.id for block in function.blocks for phi in block.phis if phi.type is Type.PRED}
    flags |= {i.id for block in function.blocks for i in block.instrs if i.type is Type.PRED}
    changed = True
    while changed:
        changed = False
        time_limit.step("control flow was simplified")
        for block in function.blocks:
            items: tuple[Phi | Instr, ...] = (*block.phis, *block.instrs)
            for item in items:
                if item.id in known:
                    continue
                if isinstance(item, Phi):
                    value = only_value(item, known)
                else:
                    value = _value(item, known, flags)
                if value is not None:
                    known[item.id] = value
                    changed = True
    return replaced(function, known)


def fold_branches(function: Function) -> Function:
    """Branches on constants, and to one target twice, become jumps; what nobody reaches goes."""
    jumps = {block.name: _decided(block.branch) for block in function.blocks}
    if not any(jumps.values()):
        return function
    blocks = (replace(b, branch=jumps[b.name] or b.branch) for b in function.blocks)
    return remove_unreachable_blocks(replace(function, blocks=tuple(blocks)))


def _value(instr: Instr, known: Mapping[int, Value], flags: Set[int]) -> Value | None:
    operands = tuple(resolved(value, known) for value in instr.operands)
    if instr.op is Opcode.MOV:
        return operands[0]
    if instr.op is Opcode.SELECT:
        return _selected(operands)
    same = all(map(is_, operands, instr.operands))
    word = constant_value(instr if same else replace(instr, operands=operands), {})
    if word is not None:
        return Const(word)
    return _neutral(instr, operands, flags)


def _selected(operands: tuple[Value, ...]) -> Value | None:
    condition, first, second = operands
    if first == second:
        return first
    if isinstance(condition, Const):
        return first if condition.word else second
    return None


def _neutral(instr: Instr, operands: tuple[Value, ...], flags: Set[int]) -> Value | None:
    """x where the operation is x + 0, x - 0, x | 0, x ^ 0, x << 0, x * 1 or x & all ones.

    `flags`: ids of predicates. The lowest bit of a word is a predicate, too, made by `and` with 1.
    """
    word = _NEUTRAL.get(instr.opcode)
    if word is None:
        return None
    if instr.op is Opcode.AND and any(isinstance(v, Ref) and v.id in flags for v in operands):
        word = 1
    left, right = operands
    if right == Const(word):
        return left
    return right if left == Const(word) and OPCODES[instr.opcode].commutes else None


def _decided(branch: Branch) -> Branch | None:
    if branch.cond is None:
        return None
    if branch.target == branch.otherwise:
        return Branch(branch.target, loc=branch.loc)
    taken = truth_of(branch.cond)
    if taken is None:
        return None
    return Branch(branch.target if taken else branch.otherwise, loc=branch.loc)


_NEUTRAL = {
    Opcode.ADD: 0,
    Opcode.SUB: 0,
    Opcode.AND: 0xFFFFFFFF,
    Opcode.OR: 0,
    Opcode.XOR: 0,
    Opcode.SHL: 0,
    Opcode.LSHR: 0,
    Opcode.ASHR: 0,
    Opcode.MUL: 1,
}
