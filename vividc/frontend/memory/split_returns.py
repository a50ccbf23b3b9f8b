"""One way out for each array that a kernel may return.

Where a kernel returns one array here and another there, LLVM lets the ways meet before the end, and
a phi chooses the pointer. What has been chosen is known on each way: the last block is copied for
each, so that every call of `RETURNED` has one array.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Final

from vividc.errors import KernelError
from vividc.frontend.llvm.calls import ALLOCATE, RETURNED, RETURNED_ARRAY
from vividc.ssa.edit import (
    FreshIds,
    incoming,
    map_values,
    resolved,
    retarget,
    with_blocks,
)
from vividc.ssa.ir import Block, Branch, Function, Global, Instr, Key, Named, Phi, Ref, Value

_MOST: Final = 64
_HINT = "return one array, and fill it here or there"


def is_returned(op: Instr) -> bool:
    """Whether a call is told a part of what the kernel returns."""
    return op.op == "call" and op.pred.startswith(RETURNED)


def is_returned_array(op: Instr) -> bool:
    """Whether what it is told is an array."""
    return is_returned(op) and op.pred.endswith(RETURNED_ARRAY)


def split_returns(function: Function) -> Function:
    """Give each array that may be returned a way out of its own.

    Raises
    ------
    KernelError
        Which array is returned cannot be told from where the kernel ends.
    """
    for _ in range(_MOST):
        found = _mixed(function)
        if found is None:
            return function
        block, op = found
        made = _split(function, block, op)
        if made is None:
            break
        function = made
    else:
        found = _mixed(function)
    if found is None:
        return function
    raise KernelError(
        "the kernel returns one of several arrays, and which one is not known where it ends",
        loc=found[1].loc,
        hint=_HINT,
    )


def _mixed(function: Function) -> tuple[Block, Instr] | None:
    """A call that is told a pointer into one of several arrays, and its block."""
    for block in function.blocks:
        for op in block.instrs:
            if is_returned_array(op) and len(set(_roots(function, op.operands[0], set()))) > 1:
                return block, op
    return None


def _roots(function: Function, pointer: Value, seen: set[Key]) -> Iterator[Key]:
    """What a pointer may point into: allocations, inputs and constants."""
    if isinstance(pointer, Global):
        yield pointer.name
    if not isinstance(pointer, Named) or pointer.key in seen:
        return
    seen.add(pointer.key)
    definition = function.definitions.get(pointer.key)
    if definition is None:
        yield pointer.key
    elif isinstance(definition, Phi):
        for _, value in definition.incoming:
            yield from _roots(function, value, seen)
    elif definition.op in ("getelementptr", "freeze"):
        yield from _roots(function, definition.operands[0], seen)
    elif definition.op == "select":
        for value in definition.operands[1:]:
            yield from _roots(function, value, seen)
    elif definition.op == "call" and definition.pred.startswith(ALLOCATE):
        yield definition.id


def _split(function: Function, block: Block, op: Instr) -> Function | None:
    """The function with the last block copied; None: the choice is made elsewhere."""
    if block.branch.successors:
        return None
    choice: Phi | Instr | None = None
    pointer = op.operands[0]
    while isinstance(pointer, Ref):
        choice = function.definitions[pointer.id]
        if not isinstance(choice, Instr) or choice.op not in ("getelementptr", "freeze"):
            break
        pointer = choice.operands[0]
    if choice is None:
        return None
    if isinstance(choice, Instr):
        return _by_condition(function, block, choice) if choice in block.instrs else None
    if choice in block.phis:
        return _by_ways(function, block)
    return _joined(function, block)


def _by_ways(function: Function, block: Block) -> Function | None:
    """A copy of a last block for each block before it."""
    ways = [b for b in function.blocks if block.name in b.branch.successors]
    if any(way.branch.target == way.branch.otherwise for way in ways):
        return None
    ids = FreshIds(function)
    changed: list[Block] = []
    for way in ways:
        name = f"{block.name}.{way.name}"
        values: dict[int, Value] = {phi.id: incoming(phi, way.name) for phi in block.phis}
        copies = {op.id: ids() for op in block.instrs}
        values |= {old: Ref(new) for old, new in copies.items()}
        body = replace(block, name=name, phis=())
        body = map_values(body, partial(_once, values))
        instrs = tuple(replace(op, id=copies[op.id]) for op in body.instrs)
        changed += [
            replace(way, branch=retarget(way.branch, block.name, name)),
            replace(body, instrs=instrs),
        ]
    made = with_blocks(function, changed)
    return replace(made, blocks=tuple(b for b in made.blocks if b.name != block.name))


def _once(values: Mapping[int, Value], value: Value) -> Value:
    return values.get(value.id, value) if isinstance(value, Ref) else value


def _joined(function: Function, block: Block) -> Function | None:
    """A last block as the end of the only one before it, if that goes nowhere else."""
    ways = [b for b in function.blocks if block.name in b.branch.successors]
    if len(ways) != 1 or ways[0].branch.cond is not None:
        return None
    way = ways[0]
    values: dict[int, Value] = {phi.id: incoming(phi, way.name) for phi in block.phis}
    body = map_values(replace(block, phis=()), lambda old: resolved(old, values))
    whole = replace(way, instrs=(*way.instrs, *body.instrs), branch=body.branch)
    made = with_blocks(function, (whole,))
    return replace(made, blocks=tuple(b for b in made.blocks if b.name != block.name))


def _by_condition(function: Function, block: Block, choice: Instr) -> Function | None:
    """A last block that ends in two ways, one for each pointer that a `select` chooses from."""
    if choice.op != "select":
        return None
    at = block.instrs.index(choice)
    names = [f"{block.name}.{way}" for way in ("then", "else")]
    head = replace(
        block,
        instrs=block.instrs[:at],
        branch=Branch(names[0], choice.operands[0], names[1], loc=choice.loc),
    )
    ids = FreshIds(function)
    ways = []
    for name, pointer in zip(names, choice.operands[1:], strict=True):
        rest = block.instrs[at + 1 :]
        copies = {op.id: ids() for op in rest}
        values: dict[int, Value] = {old: Ref(new) for old, new in copies.items()}
        values[choice.id] = pointer
        body = Block(name, (), rest, block.branch)
        body = map_values(body, partial(_once, values))
        instrs = tuple(replace(op, id=copies[op.id]) for op in body.instrs)
        ways.append(replace(body, instrs=instrs))
    return with_blocks(function, (head, *ways))
