"""Brings a CFG into the shape regions are cut from.

Afterwards: no unreachable blocks; every loop is entered from one preheader that only jumps to its
header, and has one latch; an innermost loop leaves to one block, all of whose predecessors are in
the loop and through whose phis every value of the loop is used outside (loop-closed SSA); an edge
into a block with phis is not critical.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.edit import (
    defined_types,
    first_free,
    fresh_name,
    incoming,
    next_id,
    rename_incoming,
    replaced,
    retarget,
    substitute,
    uses,
    with_blocks,
)
from vividc.ssa.flow import (
    Loop,
    blocks_of_pipelined_loops,
    find_loops,
    pipelined_loops,
    predecessors,
)
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Kind, Phi, Ref, Value
from vividc.ssa.rewrite.blocks import merge_chains, only_value, remove_unreachable_blocks


def normalize(function: Function) -> Function:
    """The same function in the shape above."""
    function = canonical_loops(function)
    for header in [loop.header for loop in pipelined_loops(function)]:
        loop = _loop_at(function, header)
        if loop.exits:
            function = _merge_exits(function, loop)
    function = _remove_trivial_phis(function)
    function = split_critical_edges(function)
    return merge_chains(function, apart=blocks_of_pipelined_loops(function))


def canonical_loops(function: Function) -> Function:
    """The same function without unreachable blocks, each loop with one preheader, which only jumps
    to its header, and one latch.
    """
    function = remove_unreachable_blocks(function)
    function = _until_stable(function, _add_one_preheader)
    return _until_stable(function, _merge_latches_of_one_loop)


def split_critical_edges(function: Function) -> Function:
    """Puts an empty block on each edge from a branching block into a block with phis."""
    changed: dict[str, Block] = {}
    by_name = {block.name: block for block in function.blocks}
    names = set(by_name)
    for block in function.blocks:
        for target in dict.fromkeys(block.branch.successors):
            if not _is_critical(function, block, by_name[target]):
                continue
            name = first_free(names, f"{block.name}.to.{target}")
            names.add(name)
            through = Block(name, (), (), Branch(target, loc=block.branch.loc))
            first = changed.get(block.name, block)
            last = changed.get(target, by_name[target])
            if target == block.name:
                first = last = _from(last, block.name, name)
            else:
                changed[target] = _from(last, block.name, name)
            changed[block.name] = replace(first, branch=retarget(first.branch, target, name))
            changed[name] = through
    return with_blocks(function, changed.values()) if changed else function


def _from(block: Block, old: str, new: str) -> Block:
    return replace(block, phis=tuple(rename_incoming(phi, old, new) for phi in block.phis))


def _is_critical(function: Function, source: Block, target: Block) -> bool:
    """Edges inside an innermost loop, and out of it, are not: if-conversion resolves them."""
    if len(source.branch.successors) == 1 or len(predecessors(function)[target.name]) == 1:
        return False
    return bool(target.phis) and source.name not in blocks_of_pipelined_loops(function)


def _until_stable(function: Function, step: Callable[[Function], Function | None]) -> Function:
    while True:
        changed = step(function)
        if changed is None:
            return function
        function = changed


def _loop_at(function: Function, header: str) -> Loop:
    return next(loop for loop in find_loops(function) if loop.header == header)


def _block(function: Function, name: str) -> Block:
    return next(block for block in function.blocks if block.name == name)


def _add_one_preheader(function: Function) -> Function | None:
    for loop in find_loops(function):
        outside = [p for p in predecessors(function)[loop.header] if p not in loop.blocks]
        is_entry = function.blocks[0].name == loop.header
        if not is_entry and len(outside) == 1:
            branch = _block(function, outside[0]).branch
            in_other_loop = outside[0] in blocks_of_pipelined_loops(function)
            if len(branch.successors) == 1 and not in_other_loop:
                continue
        return _join(function, outside, loop.header, "preheader", at_front=is_entry)
    return None


def _merge_latches_of_one_loop(function: Function) -> Function | None:
    for loop in find_loops(function):
        if len(loop.latches) > 1:
            return _join(function, list(loop.latches), loop.header, "latch")
    return None


def _join(
    function: Function, sources: list[str], target: str, stem: str, *, at_front: bool = False
) -> Function:
    """Routes the edges sources -> target through one new block with phis of its own."""
    name = fresh_name(function, f"{target}.{stem}")
    free = next_id(function)
    header = _block(function, target)
    moved, kept = [], []
    for offset, phi in enumerate(header.phis):
        inner = Phi(free + offset, phi.type, tuple((s, incoming(phi, s)) for s in sources), phi.loc)
        moved.append(inner)
        rest = tuple(item for item in phi.incoming if item[0] not in sources)
        kept.append(replace(phi, incoming=(*rest, (name, Ref(inner.id)))))
    changed = [replace(header, phis=tuple(kept))]
    by_name = {block.name: block for block in function.blocks} | {header.name: changed[0]}
    for source in sources:
        block = by_name[source]
        by_name[source] = replace(block, branch=retarget(block.branch, target, name))
    new = Block(name, tuple(moved), (), Branch(target, loc=header.branch.loc))
    function = with_blocks(function, (*by_name.values(), new))
    if at_front:
        rest_blocks = tuple(block for block in function.blocks if block.name != name)
        function = replace(function, blocks=(_block(function, name), *rest_blocks))
    return _remove_trivial_phis(function)


def _merge_exits(function: Function, loop: Loop) -> Function:
    """One exit block for an innermost loop; with several targets it branches by number."""
    targets = list(dict.fromkeys(target for _, target in loop.exits))
    if len(targets) > 1:
        function = _number_exits(function, loop, targets)
    else:
        outside = [p for p in predecessors(function)[targets[0]] if p not in loop.blocks]
        chained = any(other.header == targets[0] for other in find_loops(function))
        if outside or chained:
            sources = list(dict.fromkeys(source for source, _ in loop.exits))
            function = _join(function, sources, targets[0], "exit")
    return _close_loop(function, _loop_at(function, loop.header))


def _number_exits(function: Function, loop: Loop, targets: list[str]) -> Function:
    """A new exit block whose phi says which target was meant, and a chain of branches on it."""
    name = fresh_name(function, f"{loop.header}.exit")
    sources = list(dict.fromkeys(source for source, _ in loop.exits))
    target_of = {source: target for source, target in loop.exits}
    free = next_id(function)
    which = Phi(free, Type.I32, tuple((s, Const(targets.index(target_of[s]))) for s in sources))
    free += 1
    phis: list[Phi] = [which]
    changed: dict[str, Block] = {block.name: block for block in function.blocks}
    steps = [name] + [f"{name}.{index}" for index in range(1, len(targets) - 1)]
    for number, target in enumerate(targets):
        jumper = steps[min(number, len(steps) - 1)]
        block = changed[target]
        outer = []
        for phi in block.phis:
            inner = Phi(
                free,
                phi.type,
                tuple(
                    (s, incoming(phi, s) if target_of[s] == target else Const(0)) for s in sources
                ),
                phi.loc,
            )
            free += 1
            phis.append(inner)
            rest = tuple(item for item in phi.incoming if item[0] not in sources)
            outer.append(replace(phi, incoming=(*rest, (jumper, Ref(inner.id)))))
        changed[target] = replace(block, phis=tuple(outer))
    for source in sources:
        block = changed[source]
        changed[source] = replace(block, branch=retarget(block.branch, target_of[source], name))
    for number, step in enumerate(steps):
        test = Instr(free, Opcode.ICMP_EQ, Type.PRED, (Ref(which.id), Const(number)))
        free += 1
        last = number == len(steps) - 1
        branch = Branch(targets[number], Ref(test.id), targets[-1] if last else steps[number + 1])
        changed[step] = Block(step, tuple(phis) if number == 0 else (), (test,), branch)
    return with_blocks(function, changed.values())


def _close_loop(function: Function, loop: Loop) -> Function:
    """Every value of the loop that is used outside passes through a phi of the exit block."""
    exit_name = loop.exits[0][1]
    inside: dict[int, Kind] = {}
    for block in function.blocks:
        if block.name in loop.blocks:
            inside |= defined_types(block)
    used = inside.keys() & _used_outside(function, loop, exit_name)
    if not used:
        return function
    sources = list(dict.fromkeys(source for source, _ in loop.exits))
    free = next_id(function)
    added: list[Phi] = []
    renamed: dict[int, Value] = {}
    for number, item in enumerate(sorted(used)):
        phi = Phi(free + number, inside[item], tuple((s, Ref(item)) for s in sources))
        added.append(phi)
        renamed[item] = Ref(phi.id)
    outside = replace(
        function, blocks=tuple(b for b in function.blocks if b.name not in loop.blocks)
    )
    original_phis = _block(function, exit_name).phis
    outside = substitute(outside, renamed)
    exit_block = _block(outside, exit_name)
    exit_block = replace(exit_block, phis=(*original_phis, *added))
    changed = {block.name: block for block in outside.blocks} | {exit_name: exit_block}
    return with_blocks(function, changed.values())


def _used_outside(function: Function, loop: Loop, exit_name: str) -> set[int]:
    used: set[int] = set()
    for name, (read, into_phis) in _used_in(function).items():
        if name not in loop.blocks:
            used |= read
            if name != exit_name:
                used |= into_phis
    return used


@once_each
def _used_in(function: Function) -> Mapping[str, tuple[frozenset[int], frozenset[int]]]:
    """Values that each block reads, and that come into its phis: many loops ask."""
    return {
        block.name: (
            frozenset(value.id for value in uses(block) if isinstance(value, Ref)),
            frozenset(v.id for phi in block.phis for _, v in phi.incoming if isinstance(v, Ref)),
        )
        for block in function.blocks
    }


def _remove_trivial_phis(function: Function) -> Function:
    """A phi with one input (besides itself) is that input, unless it closes a loop."""
    inside = _defined_in_loop_before(function)
    known: dict[int, Value] = {}
    while _find_trivial(function, inside, known):
        pass
    return replaced(function, known)


def _find_trivial(function: Function, inside: dict[str, set[int]], known: dict[int, Value]) -> bool:
    """Adds the phis that are one value to `known`; whether there was one."""
    before = len(known)
    for block in function.blocks:
        closed = inside.get(block.name, ())
        for phi in block.phis:
            if phi.id in known:
                continue
            value = only_value(phi, known)
            if value is not None and not (isinstance(value, Ref) and value.id in closed):
                known[phi.id] = value
    return len(known) > before


def _defined_in_loop_before(function: Function) -> dict[str, set[int]]:
    """For each exit block of an innermost loop: the ids that the loop defines."""
    inside: dict[str, set[int]] = {}
    by_name = {block.name: block for block in function.blocks}
    for loop in pipelined_loops(function):
        ids = {item.id for name in loop.blocks for item in by_name[name].items}
        for _, target in loop.exits:
            inside.setdefault(target, set()).update(ids)
    return inside


def copy_exit_values(function: Function) -> Function:
    """A loop that reads what another loop leaves behind reads a copy made in its preheader.

    A loop leaves a value on one PE; only a straight region brings it to all PEs that a later loop
    reads it on.
    """
    loops = [loop for loop in pipelined_loops(function) if loop.exits]
    left_behind = {
        phi.id: phi.type for loop in loops for phi in _block(function, loop.exits[0][1]).phis
    }
    for loop in loops:
        outside = [p for p in predecessors(function)[loop.header] if p not in loop.blocks]
        preheader = _block(function, outside[0])
        body = [block for block in function.blocks if block.name in loop.blocks]
        closing = _block(function, loop.exits[0][1])
        values = [value for block in body for value in _all_values(block)]
        values += [value for phi in closing.phis for _, value in phi.incoming]
        read = dict.fromkeys(
            value.id for value in values if isinstance(value, Ref) and value.id in left_behind
        )
        free = next_id(function)
        copies: dict[int, Value] = {old: Ref(free + i) for i, old in enumerate(read)}
        movs = tuple(
            Instr(free + i, Opcode.MOV, left_behind[old], (Ref(old),)) for i, old in enumerate(read)
        )
        copied = substitute(replace(function, blocks=(*body, closing)), copies).blocks
        closing = replace(closing, phis=copied[-1].phis)
        preheader = replace(preheader, instrs=(*preheader.instrs, *movs))
        function = with_blocks(function, (*copied[:-1], closing))
        if preheader.name == closing.name:  # the outer loop's only other block
            preheader = replace(preheader, phis=closing.phis)
        function = with_blocks(function, (preheader,))
    return function


def _all_values(block: Block) -> list[Value]:
    return [*uses(block), *(value for phi in block.phis for _, value in phi.incoming)]
