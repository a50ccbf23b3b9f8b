"""Removes superfluous blocks and phis: unreachable blocks, straight chains, phis with one value."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import replace
from operator import is_

from vividc.host.once import changed
from vividc.ssa.edit import incoming, resolved, substitute
from vividc.ssa.flow import block_graph, predecessors
from vividc.ssa.ir import Block, Function, Phi, Ref, Value


def remove_unreachable_blocks(function: Function) -> Function:
    """Drops blocks that no path from the entry reaches, and the phi inputs that came from them."""
    graph = block_graph(function)
    kept = tuple(
        _along_edges(block, set(graph.predecessors(block.name)))
        for block in function.blocks
        if block.name in graph
    )
    same = len(kept) == len(function.blocks) and all(map(is_, kept, function.blocks))
    return function if same else replace(function, blocks=kept)


def _along_edges(block: Block, sources: set[str]) -> Block:
    """The block whose phis take values from its predecessors only."""
    if all(name in sources for phi in block.phis for name, _ in phi.incoming):
        return block
    phis = tuple(
        replace(phi, incoming=tuple(item for item in phi.incoming if item[0] in sources))
        for phi in block.phis
    )
    return replace(block, phis=phis)


def merge_chains(function: Function, apart: Set[str] = frozenset()) -> Function:
    """Joins each block with its only successor where that has no other predecessor.

    `apart`: names of blocks that stay as they are.
    """
    follower = _followers(function, apart)
    if not follower:
        return function
    by_name = {block.name: block for block in function.blocks}
    merged_away = set(follower.values())
    end_of: dict[str, str] = {}
    values: dict[int, Value] = {}
    joined = []
    for first in function.blocks:
        if first.name in merged_away:
            continue
        instrs, last = list(first.instrs), first
        while last.name in follower:
            before, last = last, by_name[follower[last.name]]
            values |= {phi.id: incoming(phi, before.name) for phi in last.phis}
            instrs += last.instrs
        end_of[last.name] = first.name
        joined.append(replace(first, instrs=tuple(instrs), branch=last.branch))
    blocks = tuple(_from_ends(block, end_of) for block in joined)
    return substitute(replace(function, blocks=blocks), values)


def only_value(phi: Phi, known: Mapping[int, Value]) -> Value | None:
    """The value that all inputs of `phi` have, itself aside, after the replacements `known`."""
    values = {resolved(value, known) for _, value in phi.incoming} - {Ref(phi.id)}
    return values.pop() if len(values) == 1 else None


def _followers(function: Function, apart: Set[str]) -> dict[str, str]:
    """The block that each block is joined with, by name."""
    entry, before = function.blocks[0].name, predecessors(function)
    follower = {}
    for block in function.blocks:
        after = block.branch.successors
        if len(after) != 1 or block.name in apart or after[0] in apart:
            continue
        if before[after[0]] == (block.name,) and after[0] not in (entry, block.name):
            follower[block.name] = after[0]
    return follower


def _from_ends(block: Block, end_of: Mapping[str, str]) -> Block:
    """`block` with inputs that come from the last block of a chain coming from the joined one."""
    if all(end_of.get(name, name) == name for phi in block.phis for name, _ in phi.incoming):
        return block
    phis = tuple(
        changed(phi, incoming=tuple((end_of.get(name, name), v) for name, v in phi.incoming))
        for phi in block.phis
    )
    return changed(block, phis=phis)
