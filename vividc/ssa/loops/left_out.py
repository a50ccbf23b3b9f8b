"""A function without some of its loops: what the rest of it takes is estimated so."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from vividc.ssa.edit import defined_types, read_values, retarget
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Function, Ref


def without_loops(function: Function, headers: Collection[str]) -> tuple[Function, frozenset[str]]:
    """The function without those of the loops that leave nothing but what they store, as if they
    had run, and the names of the blocks that it lacks. It computes something else.
    """
    taken: frozenset[str] = frozenset()
    for loop in find_loops(function):
        if loop.header in headers and _leaves_nothing(function, loop):
            function = _jumped_over(function, loop)
            taken |= loop.blocks
    return function, taken


def _leaves_nothing(function: Function, loop: Loop) -> bool:
    """Whether one block is behind the loop, and no value of the loop is read outside."""
    behind = {target for _, target in loop.exits}
    if len(behind) != 1 or function.by_name[next(iter(behind))].phis:
        return False
    own = {
        ident
        for block in function.blocks
        if block.name in loop.blocks
        for ident in defined_types(block)
    }
    return not any(
        isinstance(value, Ref) and value.id in own
        for block in function.blocks
        if block.name not in loop.blocks
        for value in read_values(block)
    )


def _jumped_over(function: Function, loop: Loop) -> Function:
    """The function with jumps past the loop where it was entered."""
    [behind] = {target for _, target in loop.exits}
    blocks = []
    for block in function.blocks:
        if block.name in loop.blocks:
            continue
        if loop.header in block.branch.successors:
            branch = retarget(block.branch, loop.header, behind)
            if branch.cond is not None and branch.target == branch.otherwise:
                branch = replace(branch, cond=None, otherwise=None)
            block = replace(block, branch=branch)  # noqa: PLW2901 - the edited copy
        blocks.append(block)
    return replace(function, blocks=tuple(blocks))
