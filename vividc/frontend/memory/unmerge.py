"""Take apart the loads that LLVM merged: one load through a choice of pointers becomes a load for
each choice.

Each array access must name its array, and a load may only run where the kernel runs it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vividc.frontend.llvm.ir import Exit, Local, Op, Operand, WideBlock, WideFunction, WidePhi


def split_merged_loads(function: WideFunction) -> WideFunction:
    """Undo `load (phi a, b)`, and `load (select c, a, b)` where a and b are of different arrays."""
    function = _split_phis(_with_own_edges(function))
    while True:
        found = _load_of_choice(function)
        if found is None:
            return function
        function = _branch_on_choice(function, *found)


def _with_own_edges(function: WideFunction) -> WideFunction:
    """A block of its own on each edge from a branch to a choice of pointers to different arrays:
    the load moves there.
    """
    definitions = function.definitions
    branches = {block.name for block in function.blocks if len(block.exit.targets) > 1}
    for block in function.blocks:
        for phi in block.phis:
            roots = {_root(definitions.get, value) for _, value in phi.incoming}
            arrays = [r for r in roots if isinstance(r, Local) and r.name not in definitions]
            if phi.type != "ptr" or len(arrays) < 2:  # noqa: PLR2004 - a choice is of two or more
                continue
            shared = [pred for pred, _ in phi.incoming if pred in branches]
            if shared:
                return _with_own_edges(_split_edge(function, shared[0], block.name))
    return function


def _split_edge(function: WideFunction, pred: str, name: str) -> WideFunction:
    edge = f"{pred}.{name}.edge"
    blocks: list[WideBlock] = []
    for block in function.blocks:
        if block.name == pred:
            targets = tuple(edge if target == name else target for target in block.exit.targets)
            blocks.append(replace(block, exit=replace(block.exit, targets=targets)))
            blocks.append(WideBlock(edge, (), (), Exit((name,), loc=block.exit.loc)))
        else:
            blocks.append(_renamed(block, pred, edge, (name,)))
    return replace(function, blocks=tuple(blocks))


def _split_phis(function: WideFunction) -> WideFunction:
    blocks = {block.name: block for block in function.blocks}
    for block in function.blocks:
        pointers = {
            phi.name: phi
            for phi in block.phis
            if phi.type == "ptr"
            # Else the load would run although the other branch is taken.
            and all(len(blocks[pred].exit.targets) == 1 for pred, _ in phi.incoming)
            and block.name not in [pred for pred, _ in phi.incoming]
        }
        if pointers:
            _split_loads_of_block(blocks, block.name, pointers)
    return replace(function, blocks=tuple(blocks[block.name] for block in function.blocks))


def _split_loads_of_block(
    blocks: dict[str, WideBlock], name: str, pointers: dict[str, WidePhi]
) -> None:
    block = blocks[name]
    new_phis: list[WidePhi] = []
    kept: list[Op] = []
    stored = False
    for op in block.ops:
        stored = stored or op.op in ("store", "call")
        pointer = op.args[0] if op.op == "load" else None
        if stored or not isinstance(pointer, Local) or pointer.name not in pointers:
            kept.append(op)
            continue
        incoming: list[tuple[str, Operand]] = []
        for index, (pred, source) in enumerate(pointers[pointer.name].incoming):
            load = replace(op, name=f"{op.name}.{index}", args=(source,), subscript=())
            blocks[pred] = replace(blocks[pred], ops=(*blocks[pred].ops, load))
            incoming.append((pred, Local(load.name)))
        new_phis.append(WidePhi(op.name, op.type, tuple(incoming), op.loc))
    blocks[name] = replace(block, phis=(*block.phis, *new_phis), ops=tuple(kept))


def _load_of_choice(function: WideFunction) -> tuple[WideBlock, int, Op] | None:
    """A load, as block and position, and the select of pointers to different arrays behind it."""
    definitions = function.definitions
    for block in function.blocks:
        for position, op in enumerate(block.ops):
            if op.op != "load":
                continue
            choice = _choice(definitions.get, op.args[0])
            if choice is not None and _root(definitions.get, choice.args[1]) != _root(
                definitions.get, choice.args[2]
            ):
                return block, position, choice
    return None


_Lookup = Callable[[str], "Op | WidePhi | None"]


def _choice(lookup: _Lookup, pointer: Operand) -> Op | None:
    while isinstance(pointer, Local):
        definition = lookup(pointer.name)
        if not isinstance(definition, Op) or definition.op not in ("select", "getelementptr"):
            return None
        if definition.op == "select":
            return definition
        pointer = definition.args[0]
    return None


def _root(lookup: _Lookup, pointer: Operand) -> Operand:
    """Where a chain of address computations starts; a choice is a start of its own."""
    while isinstance(pointer, Local):
        definition = lookup(pointer.name)
        if not isinstance(definition, Op) or definition.op != "getelementptr":
            return pointer
        pointer = definition.args[0]
    return pointer


def _branch_on_choice(
    function: WideFunction, block: WideBlock, position: int, choice: Op
) -> WideFunction:
    """Split the block at the load: a branch on the choice's condition, a load on either side, a
    phi.
    """
    load = block.ops[position]
    names = [f"{block.name}.{load.name}.{side}" for side in ("then", "else", "end")]
    sides = [
        _side(function, name, load, choice, pointer, names[2])
        for name, pointer in zip(names, choice.args[1:], strict=False)
    ]
    incoming = tuple((side.name, Local(side.ops[-1].name)) for side in sides)
    head = WideBlock(
        block.name,
        block.phis,
        block.ops[:position],
        Exit((names[0], names[1]), choice.args[0], loc=load.loc),
    )
    phi = WidePhi(load.name, load.type, incoming, load.loc)
    tail = WideBlock(names[2], (phi,), block.ops[position + 1 :], block.exit)
    blocks: list[WideBlock] = []
    for other in function.blocks:
        parts = (head, *sides, tail) if other.name == block.name else (other,)
        blocks.extend(_renamed(part, block.name, names[2], block.exit.targets) for part in parts)
    return replace(function, blocks=tuple(blocks))


def _side(
    function: WideFunction, name: str, load: Op, choice: Op, pointer: Operand, end: str
) -> WideBlock:
    """The load with the choice's one pointer: the address computations after the choice are
    repeated.
    """
    chain: list[Op] = []
    current = load.args[0]
    while current != Local(choice.name):
        assert isinstance(current, Local)
        gep = function.definitions[current.name]
        assert isinstance(gep, Op)
        chain.append(gep)
        current = gep.args[0]
    ops: list[Op] = []
    for number, gep in enumerate(reversed(chain)):
        ops.append(replace(gep, name=f"{name}.{number}", args=(pointer, *gep.args[1:])))
        pointer = Local(ops[-1].name)
    ops.append(replace(load, name=f"{name}.load", args=(pointer,), subscript=()))
    return WideBlock(name, (), tuple(ops), Exit((end,), loc=load.loc))


def _renamed(block: WideBlock, old: str, new: str, targets: tuple[str, ...]) -> WideBlock:
    """Phis of the split block's successors name its tail."""
    if block.name not in targets:
        return block
    phis = tuple(
        replace(phi, incoming=tuple((new if p == old else p, v) for p, v in phi.incoming))
        for phi in block.phis
    )
    return replace(block, phis=phis)
