"""Rewriting of CFG functions: every edit returns a new `Function`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from dataclasses import replace
from operator import is_

from vividc.host import time_limit
from vividc.host.once import changed
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Kind, Phi, Ref, Value


def next_id(function: Function) -> int:
    """An SSA id larger than all in use."""
    phis = [phi.id for block in function.blocks for phi in block.phis]
    instrs = [instr.id for block in function.blocks for instr in block.instrs]
    return max(max(phis, default=-1), max(instrs, default=-1)) + 1


class FreshIds:
    """Ids that a function does not use, for the values that a pass adds.

    `ids(key, ...)` is the same id each time for the same key, so that a value can be named before
    it is made; `ids()` is a new one.
    """

    def __init__(self, function: Function) -> None:
        self._next = next_id(function)
        self._made: dict[tuple[Hashable, ...], int] = {}

    def __call__(self, *key: Hashable) -> int:
        """The id of a key."""
        if key in self._made:
            return self._made[key]
        self._next += 1
        if key:
            self._made[key] = self._next - 1
        return self._next - 1


def defined_types(block: Block) -> dict[int, Kind]:
    """Type of each value that `block` defines, by id."""
    phis = {phi.id: phi.type for phi in block.phis}
    return phis | {instr.id: instr.type for instr in block.instrs}


def fresh_name(function: Function, stem: str) -> str:
    """A block name that starts with `stem` and is not in use."""
    return first_free({block.name for block in function.blocks}, stem)


def first_free(names: Collection[str], stem: str) -> str:
    """A name that starts with `stem` and is none of `names`."""
    candidates = (f"{stem}.{index}" if index else stem for index in range(len(names) + 1))
    return next(name for name in candidates if name not in names)


def with_blocks(function: Function, changed: Iterable[Block]) -> Function:
    """`function` with blocks replaced by name; new names are appended."""
    time_limit.step("control flow was transformed")
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
    """`block` with `change` applied to every operand, phis and branch included; what it leaves as
    it is stays the same object.
    """
    phis = tuple(_map_phi(phi, change) for phi in block.phis)
    instrs = tuple(_map_instr(instr, change) for instr in block.instrs)
    branch = _map_branch(block.branch, change)
    same = branch is block.branch and all(map(is_, phis, block.phis))
    if same and all(map(is_, instrs, block.instrs)):
        return block
    return changed(block, phis=phis, instrs=instrs, branch=branch)


def _map_phi(phi: Phi, change: Callable[[Value], Value]) -> Phi:
    values = [change(value) for _, value in phi.incoming]
    if all(new is old for new, (_, old) in zip(values, phi.incoming, strict=True)):
        return phi
    names = (name for name, _ in phi.incoming)
    return changed(phi, incoming=tuple(zip(names, values, strict=True)))


def _map_instr(instr: Instr, change: Callable[[Value], Value]) -> Instr:
    operands = tuple(map(change, instr.operands))
    if all(map(is_, operands, instr.operands)):
        return instr
    return changed(instr, operands=operands)


def _map_branch(branch: Branch, change: Callable[[Value], Value]) -> Branch:
    old = (branch.cond, branch.value, branch.high)
    new = tuple(None if value is None else change(value) for value in old)
    if all(map(is_, new, old)):
        return branch
    return replace(branch, cond=new[0], value=new[1], high=new[2])


def substitute(function: Function, values: dict[int, Value]) -> Function:
    """`function` with every use of the given ids replaced (chains of replacements are followed)."""

    if not values:
        return function
    blocks = (map_values(block, lambda old: resolved(old, values)) for block in function.blocks)
    return replace(function, blocks=tuple(blocks))


def replaced(function: Function, values: dict[int, Value]) -> Function:
    """`function` with every use of the given ids replaced, and without their definitions."""
    if not values:
        return function
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.id not in values),
            instrs=tuple(instr for instr in block.instrs if instr.id not in values),
        )
        for block in function.blocks
    )
    return substitute(replace(function, blocks=blocks), values)


def resolved(value: Value, values: Mapping[int, Value]) -> Value:
    """What stands for `value` after replacements by id, one after another."""
    while isinstance(value, Ref) and value.id in values:
        value = values[value.id]
    return value


def uses(block: Block) -> Iterator[Value]:
    """Operands of a block's instructions and branch (not of its phis)."""
    for instr in block.instrs:
        yield from instr.operands
    yield from block.branch.read


def read_values(block: Block) -> Iterator[Value]:
    """Operands of a block's phis, instructions and branch."""
    for phi in block.phis:
        yield from (value for _, value in phi.incoming)
    yield from uses(block)


def incoming(phi: Phi, source: str) -> Value:
    """The value that `phi` takes when control comes from block `source`."""
    for name, value in phi.incoming:
        if name == source:
            return value
    return Const(0)


def block_of(function: Function, name: str) -> Block:
    """The block called `name`."""
    return function.by_name[name]
