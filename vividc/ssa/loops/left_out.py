"""A function without some of its loops: what the rest of it takes is estimated so."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from vividc.ssa.edit import defined_types, read_values, retarget
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Block, Function, Ref


def without_loops(function: Function, headers: Collection[str]) -> tuple[Function, frozenset[str]]:
    """The function without those of the loops that leave nothing but what they store, as if they
    had run, and the names of the blocks that it lacks. It computes something else.
    """
    taken: frozenset[str] = frozenset()
    behind: dict[str, str] = {}
    loops = [loop for loop in reversed(find_loops(function)) if loop.header in headers]
    readers = _readers(function) if loops else {}
    for loop in loops:
        if loop.header in taken:
            continue
        target = _behind(function, loop)
        if target is not None and _leaves_nothing(function, loop, taken, readers):
            behind[loop.header] = target
            taken |= loop.blocks
    if not taken:
        return function, taken
    left = (block for block in function.blocks if block.name not in taken)
    return replace(function, blocks=tuple(_jumped(block, behind) for block in left)), taken


def _readers(function: Function) -> dict[int, set[str]]:
    """Names of the blocks that read each value."""
    readers: dict[int, set[str]] = {}
    for block in function.blocks:
        for value in read_values(block):
            if isinstance(value, Ref):
                readers.setdefault(value.id, set()).add(block.name)
    return readers


def _behind(function: Function, loop: Loop) -> str | None:
    """The only block behind a loop, if that takes no values from it."""
    behind = {target for _, target in loop.exits}
    target = behind.pop() if len(behind) == 1 else None
    return None if target is None or function.by_name[target].phis else target


def _leaves_nothing(
    function: Function, loop: Loop, taken: frozenset[str], readers: Mapping[int, set[str]]
) -> bool:
    """Whether no value of the loop is read outside, but in blocks that are taken."""
    inside = loop.blocks | taken
    return all(
        readers[ident] <= inside
        for name in loop.blocks
        for ident in defined_types(function.by_name[name])
        if ident in readers
    )


def _jumped(block: Block, behind: Mapping[str, str]) -> Block:
    """The block with jumps past loops where they were entered."""
    for name in block.branch.successors:
        target = name
        while target in behind:
            target = behind[target]
        if target == name:
            continue
        branch = retarget(block.branch, name, target)
        if branch.cond is not None and branch.target == branch.otherwise:
            branch = replace(branch, cond=None, otherwise=None)
        block = replace(block, branch=branch)
    return block
