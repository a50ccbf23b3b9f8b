"""Take apart the loads that LLVM merged: one load through a choice of pointers becomes a load for
each choice.

Each array access must name its array, and a load may only run where the kernel runs it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vividc.ssa.edit import FreshIds, retarget
from vividc.ssa.ir import Block, Branch, Function, Input, Instr, Key, Named, Phi, Ref, Value


def split_merged_loads(function: Function) -> Function:
    """Undo `load (phi a, b)`, and `load (select c, a, b)` where a and b are of different arrays."""
    function = _split_phis(_with_own_edges(function))
    while True:
        merged = _load_of_choice(function)
        if merged is None:
            return function
        function = _branch_on_choice(function, *merged)


def _with_own_edges(function: Function) -> Function:
    """A block of its own on each edge from a branch to a choice of pointers to different arrays:
    the load moves there.
    """
    definitions = function.definitions
    branches = {block.name for block in function.blocks if len(block.branch.successors) > 1}
    for block in function.blocks:
        for phi in block.phis:
            roots = {_root(definitions.get, value) for _, value in phi.incoming}
            arrays = [r for r in roots if isinstance(r, Input)]
            if phi.type != "ptr" or len(arrays) < 2:  # noqa: PLR2004 - a choice is of two or more
                continue
            shared = [pred for pred, _ in phi.incoming if pred in branches]
            if shared:
                return _with_own_edges(_split_edge(function, shared[0], block.name))
    return function


def _split_edge(function: Function, pred: str, name: str) -> Function:
    edge = f"{pred}.{name}.edge"
    blocks: list[Block] = []
    for block in function.blocks:
        if block.name == pred:
            blocks.append(replace(block, branch=retarget(block.branch, name, edge)))
            blocks.append(Block(edge, (), (), Branch(name, loc=block.branch.loc)))
        else:
            blocks.append(_renamed(block, pred, edge, (name,)))
    return replace(function, blocks=tuple(blocks))


def _split_phis(function: Function) -> Function:
    blocks, ids = dict(function.by_name), FreshIds(function)
    for block in function.blocks:
        pointers: dict[Key, Phi] = {
            phi.id: phi
            for phi in block.phis
            if phi.type == "ptr"
            # Else the load would run although the other branch is taken.
            and all(len(blocks[pred].branch.successors) == 1 for pred, _ in phi.incoming)
            and block.name not in [pred for pred, _ in phi.incoming]
        }
        if pointers:
            _split_loads_of_block(blocks, block.name, pointers, ids)
    return replace(function, blocks=tuple(blocks[block.name] for block in function.blocks))


def _split_loads_of_block(
    blocks: dict[str, Block], name: str, pointers: dict[Key, Phi], ids: FreshIds
) -> None:
    block = blocks[name]
    new_phis: list[Phi] = []
    kept: list[Instr] = []
    stored = False
    for op in block.instrs:
        stored = stored or op.op in ("store", "call")
        pointer = op.operands[0] if op.op == "load" else None
        if stored or not isinstance(pointer, Named) or pointer.key not in pointers:
            kept.append(op)
            continue
        incoming: list[tuple[str, Value]] = []
        for pred, source in pointers[pointer.key].incoming:
            load = replace(op, id=ids(), operands=(source,), subscript=())
            blocks[pred] = replace(blocks[pred], instrs=(*blocks[pred].instrs, load))
            incoming.append((pred, Ref(load.id)))
        new_phis.append(Phi(op.id, op.type, tuple(incoming), op.loc))
    blocks[name] = replace(block, phis=(*block.phis, *new_phis), instrs=tuple(kept))


def _load_of_choice(function: Function) -> tuple[Block, int, Instr] | None:
    """A load, as block and position, and the select of pointers to different arrays behind it."""
    definitions = function.definitions
    for block in function.blocks:
        for position, op in enumerate(block.instrs):
            if op.op != "load":
                continue
            choice = _choice(definitions.get, op.operands[0])
            if choice is not None and _root(definitions.get, choice.operands[1]) != _root(
                definitions.get, choice.operands[2]
            ):
                return block, position, choice
    return None


_Lookup = Callable[[Key], "Instr | Phi | None"]


def _choice(lookup: _Lookup, pointer: Value) -> Instr | None:
    while isinstance(pointer, Named):
        definition = lookup(pointer.key)
        if not isinstance(definition, Instr) or definition.op not in ("select", "getelementptr"):
            return None
        if definition.op == "select":
            return definition
        pointer = definition.operands[0]
    return None


def _root(lookup: _Lookup, pointer: Value) -> Value:
    """Where a chain of address computations starts; a choice is a start of its own."""
    while isinstance(pointer, Named):
        definition = lookup(pointer.key)
        if not isinstance(definition, Instr) or definition.op != "getelementptr":
            return pointer
        pointer = definition.operands[0]
    return pointer


def _branch_on_choice(function: Function, block: Block, position: int, choice: Instr) -> Function:
    """Split the block at the load: a branch on the choice's condition, a load on either side, a
    phi.
    """
    load = block.instrs[position]
    ids = FreshIds(function)
    names = [f"{block.name}.{load.id}.{side}" for side in ("then", "else", "end")]
    end = Branch(names[2], loc=load.loc)
    sides = [
        Block(name, (), _accesses(function, load, choice, pointer, ids), end)
        for name, pointer in zip(names, choice.operands[1:], strict=False)
    ]
    incoming = tuple((side.name, Ref(side.instrs[-1].id)) for side in sides)
    head = Block(
        block.name,
        block.phis,
        block.instrs[:position],
        Branch(names[0], choice.operands[0], names[1], loc=load.loc),
    )
    phi = Phi(load.id, load.type, incoming, load.loc)
    tail = Block(names[2], (phi,), block.instrs[position + 1 :], block.branch)
    blocks: list[Block] = []
    for other in function.blocks:
        parts = (head, *sides, tail) if other.name == block.name else (other,)
        blocks.extend(
            _renamed(part, block.name, names[2], block.branch.successors) for part in parts
        )
    return replace(function, blocks=tuple(blocks))


def _accesses(
    function: Function, load: Instr, choice: Instr, pointer: Value, ids: FreshIds
) -> tuple[Instr, ...]:
    """The load with the choice's one pointer: the address computations after the choice are
    repeated.
    """
    chain: list[Instr] = []
    current = load.operands[0]
    while current != Ref(choice.id):
        assert isinstance(current, Named)
        gep = function.definitions[current.key]
        assert isinstance(gep, Instr)
        chain.append(gep)
        current = gep.operands[0]
    instrs: list[Instr] = []
    for gep in reversed(chain):
        instrs.append(replace(gep, id=ids(), operands=(pointer, *gep.operands[1:])))
        pointer = Ref(instrs[-1].id)
    return (*instrs, replace(load, id=ids(), operands=(pointer,), subscript=()))


def _renamed(block: Block, old: str, new: str, targets: tuple[str, ...]) -> Block:
    """Phis of the split block's successors name its tail."""
    if block.name not in targets:
        return block
    phis = tuple(
        replace(phi, incoming=tuple((new if p == old else p, v) for p, v in phi.incoming))
        for phi in block.phis
    )
    return replace(block, phis=phis)
