"""A loop as a graph of its own blocks and of the loops inside it, each of which stands for one
node: what is between two inner loops has no cycle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import networkx as nx

from vividc.ssa.analysis.acyclic import Acyclic, Edge
from vividc.ssa.edit import block_of, defined_types, fresh_name, redirect_edge, uses
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Block, Branch, Function, Kind, Ref, Value


@dataclass(frozen=True)
class Level:
    """A loop, with the loops directly inside it by header.

    A node of the level is a block of the loop that is in no inner one, or the header of an inner
    loop, which stands for all of it.
    """

    function: Function
    loop: Loop
    children: dict[str, Level]

    @cached_property
    def blocks(self) -> dict[str, Block]:
        """All blocks of the loop, inner loops included."""
        return {b.name: b for b in self.function.blocks if b.name in self.loop.blocks}

    @cached_property
    def header(self) -> Block:
        """The loop's header."""
        return self.blocks[self.loop.header]

    @cached_property
    def _child_of(self) -> dict[str, str]:
        return {name: h for h, child in self.children.items() for name in child.loop.blocks}

    def node(self, block: str) -> str:
        """The node that a block belongs to."""
        return self._child_of.get(block, block)

    @cached_property
    def edges(self) -> tuple[Edge, ...]:
        """Edges between blocks of different nodes, the back edge aside."""
        return tuple(
            (name, target)
            for name, block in self.blocks.items()
            for target in dict.fromkeys(block.branch.successors)
            if target in self.loop.blocks
            and target != self.loop.header
            and self.node(name) != self.node(target)
        )

    @cached_property
    def flow(self) -> Acyclic:
        """The nodes, without the back edge."""
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(dict.fromkeys(map(self.node, self.blocks)))
        graph.add_edges_from((self.node(a), self.node(b)) for a, b in self.edges)
        return Acyclic(graph, self.loop.header)

    def exits_before(self, block: str) -> tuple[Edge, ...]:
        """Exits of the loop that an iteration may have met before it comes to a block."""
        node = self.node(block)
        return tuple(
            (source, target)
            for source, target in self.exits
            if self.node(source) != node and self.flow.reaches(self.node(source), node)
        )

    @cached_property
    def exits(self) -> tuple[Edge, ...]:
        """Edges out of the loop, in the order in which an iteration meets them."""
        position = {name: index for index, name in enumerate(self.flow.order)}
        return tuple(sorted(self.loop.exits, key=lambda edge: position[self.node(edge[0])]))

    @property
    def latch(self) -> str:
        """The block that leads back to the header."""
        return self.loop.latches[0]

    @cached_property
    def types(self) -> dict[int, Kind]:
        """Types of the values that the loop defines."""
        types: dict[int, Kind] = {}
        for block in self.blocks.values():
            types |= defined_types(block)
        return types

    @cached_property
    def leaving(self) -> tuple[int, ...]:
        """Ids of values of the loop that are read outside it, in order of definition."""
        read: set[int] = set()
        for block in self.function.blocks:
            if block.name in self.loop.blocks:
                continue
            values: list[Value] = list(uses(block))
            values += [value for phi in block.phis for _, value in phi.incoming]
            read |= {value.id for value in values if isinstance(value, Ref)}
        return tuple(ident for ident in self.types if ident in read)

    def all_levels(self) -> Iterator[Level]:
        """This level and those inside it."""
        yield self
        for child in self.children.values():
            yield from child.all_levels()


def level_of(function: Function, header: str) -> Level:
    """The level of the loop with this header; the loops in it have one preheader and one latch.

    The latches must be blocks of the loops themselves: see `with_own_latches`.
    """
    loops = find_loops(function)
    loop = next(loop for loop in loops if loop.header == header)
    return _level(function, loop, loops)


def with_own_latches(function: Function, header: str) -> Function:
    """`function` with an empty block on each back edge, in the loop at `header`, that leads from an
    inner loop straight to the header of the one around it.
    """
    while True:
        edge = _foreign_latch(function, header)
        if edge is None:
            return function
        source, target = edge
        name = fresh_name(function, f"{target}.latch")
        loc = block_of(function, target).branch.loc
        function = redirect_edge(
            function, source, target, Block(name, (), (), Branch(target, loc=loc))
        )


def _foreign_latch(function: Function, header: str) -> Edge | None:
    loops = find_loops(function)
    outermost = next(loop for loop in loops if loop.header == header)
    for loop in loops:
        if loop.header not in outermost.blocks:
            continue
        for inner in loops:
            smaller = len(inner.blocks) < len(loop.blocks) and inner.blocks < loop.blocks
            if smaller and loop.latches[0] in inner.blocks:
                return loop.latches[0], loop.header
    return None


def _level(function: Function, loop: Loop, loops: tuple[Loop, ...]) -> Level:
    inside = [o for o in loops if o.header in loop.blocks and o.header != loop.header]
    direct = [
        o for o in inside if not any(o.header in m.blocks and m.header != o.header for m in inside)
    ]
    children = {child.header: _level(function, child, loops) for child in direct}
    return Level(function, loop, children)
