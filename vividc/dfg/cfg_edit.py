"""Rewriting of CFG functions: every edit returns a new `Function`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from vividc.dfg.cfg import Block, Branch, Const, Function, Instr, Phi, Ref, Value
from vividc.dfg.opcodes import Type


def next_id(function: Function) -> int:
    """An SSA id larger than all in use."""
    return (
        max((ident for block in function.blocks for ident in defined_types(block)), default=-1) + 1
    )


def defined_types(block: Block) -> dict[int, Type]:
    """Type of each value that `block` defines, by id."""
    phis = {phi.id: phi.type for phi in block.phis}
    return phis | {instr.id: instr.type for instr in block.instrs}


def definitions(block: Block) -> tuple[Phi | Instr, ...]:
    """Phis, then instructions."""
    return (*block.phis, *block.instrs)


def fresh_name(function: Function, stem: str) -> str:
    """A block name that starts with `stem` and is not in use."""
    names = {block.name for block in function.blocks}
    candidates = (f"{stem}.{index}" if index else stem for index in range(len(names) + 1))
    return next(name for name in candidates if name not in names)


def with_blocks(function: Function, changed: Iterable[Block]) -> Function:
    """`function` with blocks replaced by name; new names are appended."""
    new = {block.name: block for block in changed}
    kept = [new.pop(block.name, block) for block in function.blocks]
    return replace(function, blocks=(*kept, *new.values()))


def retarget(branch: Branch, old: str, new: str) -> Branch:
    """`branch` with every jump to `old` going to `new`."""
    return replace(
        branch,
        target=new if branch.target == old else branch.target,
        otherwise=new if branch.otherwise == old else branch.otherwise,
    )


def rename_incoming(phi: Phi, old: str, new: str) -> Phi:
    """`phi` whose incoming value from block `old` comes from block `new`."""
    return replace(
        phi, incoming=tuple((new if name == old else name, value) for name, value in phi.incoming)
    )


def redirect_edge(function: Function, source: str, target: str, through: Block) -> Function:
    """Puts `through`, a block that jumps to `target`, on the edge source -> target."""
    by_name = {block.name: block for block in function.blocks}
    first = by_name[source]
    first = replace(first, branch=retarget(first.branch, target, through.name))
    last = by_name[target]
    last = replace(
        last, phis=tuple(rename_incoming(phi, source, through.name) for phi in last.phis)
    )
    if source == target:
        first = replace(first, phis=last.phis)
        return with_blocks(function, (first, through))
    return with_blocks(function, (first, last, through))


def map_values(block: Block, change: Callable[[Value], Value]) -> Block:
    """`block` with `change` applied to every operand, phis and branch included."""
    branch = block.branch
    return replace(
        block,
        phis=tuple(
            replace(phi, incoming=tuple((name, change(value)) for name, value in phi.incoming))
            for phi in block.phis
        ),
        instrs=tuple(
            replace(instr, operands=tuple(change(value) for value in instr.operands))
            for instr in block.instrs
        ),
        branch=replace(
            branch,
            cond=None if branch.cond is None else change(branch.cond),
            value=None if branch.value is None else change(branch.value),
            high=None if branch.high is None else change(branch.high),
        ),
    )


def substitute(function: Function, values: dict[int, Value]) -> Function:
    """`function` with every use of the given ids replaced (chains of replacements are followed)."""

    def change(value: Value) -> Value:
        while isinstance(value, Ref) and value.id in values:
            value = values[value.id]
        return value

    return replace(function, blocks=tuple(map_values(block, change) for block in function.blocks))


def uses(block: Block) -> Iterator[Value]:
    """Operands of a block's instructions and branch (not of its phis)."""
    for instr in block.instrs:
        yield from instr.operands
    yield from block.branch.read


def incoming(phi: Phi, source: str) -> Value:
    """The value that `phi` takes when control comes from block `source`."""
    for name, value in phi.incoming:
        if name == source:
            return value
    return Const(0)
