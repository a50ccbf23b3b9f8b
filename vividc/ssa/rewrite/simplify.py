"""Simplification of a function after control flow was copied or redirected.

Constants are folded, branches on constants become jumps, unreachable blocks, trivial phis and
results that nobody reads go, and straight chains of blocks become one block.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace

from vividc.host import time_limit
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.ssa.analysis.constants import constant_value
from vividc.ssa.edit import incoming, map_values, rename_incoming
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Value, truth_of
from vividc.ssa.rewrite.normalize import remove_unreachable_blocks


def simplify(function: Function) -> Function:
    """The same function with less control flow; the same object if nothing can be simplified."""
    before = None
    while function is not before:
        before = function
        function = fold_values(function)
        function = fold_branches(function)
        function = merge_straight_chains(function)
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
                    value = _phi_value(item, known)
                else:
                    value = _value(item, known, flags)
                if value is not None:
                    known[item.id] = value
                    changed = True
    return _without(function, known) if known else function


def fold_branches(function: Function) -> Function:
    """Branches on constants, and to one target twice, become jumps; what nobody reaches goes."""
    jumps = {block.name: _decided(block.branch) for block in function.blocks}
    if not any(jumps.values()):
        return function
    blocks = (replace(b, branch=jumps[b.name] or b.branch) for b in function.blocks)
    return remove_unreachable_blocks(replace(function, blocks=tuple(blocks)))


def merge_straight_chains(function: Function) -> Function:
    """Joins each block with its only successor where that has no other predecessor."""
    by_name = {block.name: block for block in function.blocks}
    count: dict[str, int] = {}
    for block in function.blocks:
        for target in dict.fromkeys(block.branch.successors):
            count[target] = count.get(target, 0) + 1
    entry = function.blocks[0].name
    follower = {
        block.name: block.branch.successors[0]
        for block in function.blocks
        if len(block.branch.successors) == 1
        and count[block.branch.successors[0]] == 1
        and block.branch.successors[0] not in (entry, block.name)
    }
    if not follower:
        return function
    merged_away = set(follower.values())
    merge = _Chains(by_name, follower)
    blocks = [merge.joined(b) for b in function.blocks if b.name not in merged_away]
    renamed = [_renamed_phis(block, merge.end_of) for block in blocks]
    return _substituted(replace(function, blocks=tuple(renamed)), merge.values)


def remove_unused(function: Function) -> Function:
    """Drops phis and instructions, stores aside, that no store, branch or return depends on."""
    operands: dict[int, Iterable[Value]] = {}
    work: list[Value] = []
    for block in function.blocks:
        operands |= {phi.id: [value for _, value in phi.incoming] for phi in block.phis}
        for instr in block.instrs:
            operands[instr.id] = instr.operands
            if instr.op is Opcode.STORE:
                work += instr.operands
        work += block.branch.read
    used: set[int] = set()
    while work:
        value = work.pop()
        if isinstance(value, Ref) and value.id not in used:
            used.add(value.id)
            work += operands[value.id]
    stores = {i.id for b in function.blocks for i in b.instrs if i.op is Opcode.STORE}
    if used | stores >= operands.keys():
        return function
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.id in used),
            instrs=tuple(i for i in block.instrs if i.id in used or i.id in stores),
        )
        for block in function.blocks
    )
    return replace(function, blocks=blocks)


def _resolve(value: Value, known: Mapping[int, Value]) -> Value:
    while isinstance(value, Ref) and value.id in known:
        value = known[value.id]
    return value


def _phi_value(phi: Phi, known: Mapping[int, Value]) -> Value | None:
    values = {_resolve(value, known) for _, value in phi.incoming} - {Ref(phi.id)}
    return values.pop() if len(values) == 1 else None


def _value(instr: Instr, known: Mapping[int, Value], flags: Set[int]) -> Value | None:
    operands = tuple(_resolve(value, known) for value in instr.operands)
    if instr.op is Opcode.MOV:
        return operands[0]
    if instr.op is Opcode.SELECT:
        return _selected(operands)
    word = constant_value(replace(instr, operands=operands), {})
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


def _without(function: Function, known: Mapping[int, Value]) -> Function:
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.id not in known),
            instrs=tuple(instr for instr in block.instrs if instr.id not in known),
        )
        for block in function.blocks
    )
    return _substituted(replace(function, blocks=blocks), known)


def _substituted(function: Function, known: Mapping[int, Value]) -> Function:
    blocks = tuple(map_values(block, lambda v: _resolve(v, known)) for block in function.blocks)
    return replace(function, blocks=blocks)


def _renamed_phis(block: Block, names: Mapping[str, str]) -> Block:
    phis = block.phis
    for old in {name for phi in phis for name, _ in phi.incoming if name in names}:
        phis = tuple(rename_incoming(phi, old, names[old]) for phi in phis)
    return replace(block, phis=phis)


@dataclass
class _Chains:
    """Joins chains; `end_of` maps the last block of each to the joined block's name, `values` its
    phis to what they were.
    """

    by_name: Mapping[str, Block]
    follower: Mapping[str, str]

    def __post_init__(self) -> None:
        self.end_of: dict[str, str] = {}
        self.values: dict[int, Value] = {}

    def joined(self, first: Block) -> Block:
        """`first` with everything that follows it."""
        if first.name not in self.follower:
            return first
        instrs = list(first.instrs)
        last = first
        while last.name in self.follower:
            following = self.by_name[self.follower[last.name]]
            self.values |= {phi.id: incoming(phi, last.name) for phi in following.phis}
            instrs += following.instrs
            last = following
        self.end_of[last.name] = first.name
        return replace(first, instrs=tuple(instrs), branch=last.branch)


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
