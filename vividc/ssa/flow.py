"""Dominators and natural loops of a kernel's control-flow graph."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import networkx as nx

from vividc.host import time_limit
from vividc.host.once import once_each
from vividc.ssa.ir import Block, Function


@dataclass(frozen=True)
class Loop:
    """A natural loop: the blocks that reach a back edge to `header` without leaving through it.

    `exits` are its edges (exiting block, target outside), in block order.
    """

    header: str
    blocks: frozenset[str]
    latches: tuple[str, ...]
    exits: tuple[tuple[str, str], ...]


@once_each
def block_graph(function: Function) -> nx.DiGraph[str]:
    """Control flow between the blocks that can be reached from the entry."""
    time_limit.step("control flow was analysed")
    by_name = {block.name: block for block in function.blocks}
    graph: nx.DiGraph[str] = nx.DiGraph()
    work = [function.blocks[0].name]
    graph.add_node(work[0])
    while work:
        name = work.pop()
        for target in by_name[name].branch.successors:
            if target not in graph:
                work.append(target)
            graph.add_edge(name, target)
    return nx.freeze(graph)


@once_each
def predecessors(function: Function) -> Mapping[str, tuple[str, ...]]:
    """The blocks that may come before each block, in block order, unreachable ones among them."""
    time_limit.step("control flow was analysed")
    found: dict[str, list[str]] = {block.name: [] for block in function.blocks}
    for block in function.blocks:
        for target in dict.fromkeys(block.branch.successors):
            found[target].append(block.name)
    return {name: tuple(sources) for name, sources in found.items()}


def dominators(graph: nx.DiGraph[str], entry: str) -> dict[str, frozenset[str]]:
    """The blocks that dominate each block, itself included."""
    idom = nx.immediate_dominators(graph, entry)
    result = {entry: frozenset((entry,))}
    for name in graph.nodes:
        chain = [name]
        while chain[-1] not in result:
            chain.append(idom[chain[-1]])
        above = result[chain.pop()]
        for below in reversed(chain):
            above = result[below] = above | {below}
    return result


@once_each
def find_loops(function: Function) -> tuple[Loop, ...]:
    """All natural loops, innermost first (fewest blocks), then in block order."""
    graph = block_graph(function)
    above = dominators(graph, function.blocks[0].name)
    latches: dict[str, list[str]] = {}
    for source, target in graph.edges:
        if target in above[source]:
            latches.setdefault(target, []).append(source)
    order = {block.name: index for index, block in enumerate(function.blocks)}
    loops = [
        _loop(function.blocks, graph, header, sorted(latches[header], key=order.__getitem__))
        for header in sorted(latches, key=order.__getitem__)
    ]
    return tuple(sorted(loops, key=lambda loop: (len(loop.blocks), order[loop.header])))


@once_each
def pipelined_loops(function: Function) -> tuple[Loop, ...]:
    """The loops to modulo-schedule: those that contain no other, have an exit, and are not
    `sequential`.
    """
    every = find_loops(function)
    return tuple(
        loop
        for loop in every
        if loop.exits
        and loop.header not in function.sequential
        and not any(other is not loop and other.header in loop.blocks for other in every)
    )


@once_each
def blocks_of_pipelined_loops(function: Function) -> frozenset[str]:
    """Names of the blocks of loops to modulo-schedule."""
    return frozenset(name for loop in pipelined_loops(function) for name in loop.blocks)


def _loop(
    blocks: tuple[Block, ...], graph: nx.DiGraph[str], header: str, latches: list[str]
) -> Loop:
    body = {header}
    work = [latch for latch in latches if latch != header]
    while work:
        name = work.pop()
        if name not in body:
            body.add(name)
            work.extend(graph.predecessors(name))
    exits = tuple(
        (block.name, target)
        for block in blocks
        if block.name in body
        for target in dict.fromkeys(block.branch.successors)
        if target not in body
    )
    return Loop(header, frozenset(body), tuple(latches), exits)


def preheader_of(function: Function, loop: Loop) -> str:
    """The block that enters the loop."""
    return next(
        block.name
        for block in function.blocks
        if loop.header in block.branch.successors and block.name not in loop.blocks
    )
