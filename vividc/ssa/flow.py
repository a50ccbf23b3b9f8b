"""Dominators and natural loops of a kernel's control-flow graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    sources_of: dict[str, list[str]] = {block.name: [] for block in function.blocks}
    for block in function.blocks:
        for target in dict.fromkeys(block.branch.successors):
            sources_of[target].append(block.name)
    return {name: tuple(sources) for name, sources in sources_of.items()}


@once_each
def immediate_dominators(function: Function) -> Mapping[str, str]:
    """Of each block that can be reached the nearest other one that dominates it; the entry's is
    itself.
    """
    entry = function.blocks[0].name
    return {**nx.immediate_dominators(block_graph(function), entry), entry: entry}


@once_each
def dominators(function: Function) -> Mapping[str, frozenset[str]]:
    """The blocks that dominate each block that can be reached, itself included."""
    entry = function.blocks[0].name
    graph = block_graph(function)
    idom = immediate_dominators(function)
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
    above = dominators(function)
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


@dataclass(frozen=True)
class Flow:
    """A tree of dominators, the blocks in reverse postorder, and the blocks of the natural loop of
    each header, in that order of the headers.
    """

    entry: str
    order: tuple[str, ...]
    successors: Mapping[str, tuple[str, ...]]
    predecessors: Mapping[str, tuple[str, ...]]
    idom: Mapping[str, str]
    loops: Mapping[str, frozenset[str]]

    def dominates(self, a: str, b: str) -> bool:
        """Whether every path from the entry to `b` passes `a` (a block dominates itself)."""
        while b not in (a, self.entry):
            b = self.idom[b]
        return a == b

    def dominators(self, name: str) -> Iterator[str]:
        """`name`, its immediate dominator, and so on up to the entry."""
        yield name
        while name != self.entry:
            name = self.idom[name]
            yield name


@once_each
def flow_of(function: Function) -> Flow:
    """Dominators and loops of a function without unreachable blocks."""
    graph, entry = block_graph(function), function.blocks[0].name
    order = tuple(reversed([*nx.dfs_postorder_nodes(graph, entry)]))
    successors = {block.name: block.branch.successors for block in function.blocks}
    bodies = {loop.header: loop.blocks for loop in find_loops(function)}
    loops = {name: bodies[name] for name in order if name in bodies}
    idom = immediate_dominators(function)
    return Flow(entry, order, successors, predecessors(function), idom, loops)
