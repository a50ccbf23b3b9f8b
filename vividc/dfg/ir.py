"""The dataflow graph of one region: frozen nodes and edges, and nothing else.

A DFG describes one iteration of a loop region, or the whole of a straight region. Constants, live-
ins and the induction value are nodes too (`SOURCES`): a fabric reads them from a PE's constant
store or from the tile controller, so a mapper neither places nor routes them. `live_out` nodes are
delivered to a PE's constant store; they are placed, but use no FU.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from vividc.errors import SourceLoc
from vividc.host.once import made_soon
from vividc.machine.foreign_names import CLASS_OF_NAME
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import (
    MEMORY,
    OPCODES,
    ORDER,
    SOURCES,
    LatencyClass,
    Named,
    Opcode,
    OpInfo,
)

if TYPE_CHECKING:
    from pathlib import Path

    from vividc.host.plot import Picture


class Control(Named):
    """What the tile controller does with a node's result, which it gets when it is ready."""

    EXIT = "exit"  # loop: 1 ends the loop after this iteration
    BRANCH = "branch"  # straight region: 1 takes the region's branch
    TRIP = "trip"  # straight region: trip count of the next counted loop


class EdgeKind(Named):
    """DATA carries a word. ORDER separates two memory operations. CONTROL runs from the exit node
    to an effect.
    """

    DATA = "data"
    ORDER = "order"
    CONTROL = "control"


AddressForm = tuple[tuple[tuple[str, ...], int], ...]
"""A byte address as a sum of products of words, each with its factor: the number of the iteration
(`polynomial.ITERATION`), inputs by key, words that no iteration changes by any name, and words that
each iteration has anew by names that begin with `CHANGES`; of these, by names that begin with
`FROM_END`, what a subscript that might be negative is counted from, which is expected to be 0.
"""
CHANGES: Final = "~"
FROM_END: Final = f"{CHANGES}end "


@made_soon
@dataclass(frozen=True, slots=True)
class Node:
    """One operation. Ids are ints in creation order; they need not be dense.

    Attributes
    ----------
    const
        The word of a `const` node (0 .. 2**32-1).
    name
        Variable of a `live_in` or `live_out`; array of a load or store; original operation of a
        `generic` node.
    shift, offset
        Memory operations: byte address = base + (index << shift) + offset.
    width, signed
        Memory operations: bytes accessed, 1, 2 or 4; a load of less than a word extends it with its
        sign or with zeros.
    control
        The controller's use of the result, if any.
    unless_exit
        Effects (store, live_out): suppressed in the iteration whose exit node is 1. Loads: the
        exiting iteration may not come so far, so there the address may lie outside the memory.
    label
        What the file that the node comes from calls it, for messages; not in the text form.
    lane
        The thread of the tile that the node belongs to, if it is one's own; not in the text form.
    address
        Memory operations: the address that every iteration has, where it is known; it tells which
        accesses meet in a bank, decides nothing else, and is not in the text form.
    """

    id: int
    op: Opcode
    const: int | None = None
    name: str = ""
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    control: Control | None = None
    unless_exit: bool = False
    loc: SourceLoc | None = field(default=None, compare=False)
    label: str = field(default="", compare=False)
    lane: Lane | None = field(default=None, compare=False)
    address: AddressForm | None = field(default=None, compare=False)

    @property
    def info(self) -> OpInfo:
        """The row of the opcode table."""
        return OPCODES[self.op]

    @property
    def latency_class(self) -> LatencyClass:
        """Which of the fabric's latencies applies; for a foreign operation by its name."""
        if self.op is Opcode.GENERIC:
            return CLASS_OF_NAME.get(self.name.lower(), LatencyClass.GENERIC)
        return OPCODES[self.op].latency_class

    @property
    def is_source(self) -> bool:
        """Constant, live-in or induction value: neither placed nor routed."""
        return self.op in SOURCES

    @property
    def is_memory(self) -> bool:
        """Load or store: needs a PE with a load/store unit."""
        return self.op in MEMORY

    @property
    def uses_fu(self) -> bool:
        """Takes an issue slot of an FU."""
        return not self.is_source and self.op is not Opcode.LIVE_OUT


@made_soon
@dataclass(frozen=True, slots=True)
class Edge:
    """`src` feeds operand `port` of `dst`, `distance` iterations later (0: the same iteration).

    With `distance` d > 0, iterations 0 .. d-1 of `dst` read the source node `init` instead (only d
    = 1 is executable). ORDER and CONTROL edges have port `ORDER` and carry no value: start[dst] +
    II * distance >= start[src] + separation, where the separation is 1 cycle for ORDER and
    latency(src) + the fabric's control latency for CONTROL.

    `assumed`: an ORDER edge between accesses that could not be proved apart, so that its distance
    is the least possible one. Like a location it tells where the edge is from, and makes no other.
    """

    src: int
    dst: int
    port: int
    distance: int = 0
    init: int | None = None
    kind: EdgeKind = EdgeKind.DATA
    assumed: bool = field(default=False, compare=False)

    @property
    def is_data(self) -> bool:
        """Carries a word."""
        return self.kind is EdgeKind.DATA


_KIND: Final = attrgetter("op", "const", "name")
_ENDS: Final = attrgetter("src", "dst")


@dataclass(frozen=True)
class DFG:
    """A region's graph. Nodes and edges keep creation order; equality is structural."""

    name: str
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        # Not of all fields: each node and edge would be asked for its own, which takes four times
        # as long.
        nodes, edges = map(_KIND, self.nodes), map(_ENDS, self.edges)
        return hash((self.name, tuple(nodes), tuple(edges)))

    def __repr__(self) -> str:
        return f"<DFG {self.name}: {len(self.nodes)} nodes, {len(self.edges)} edges>"

    @cached_property
    def by_id(self) -> dict[int, Node]:
        """Node of each id."""
        return {node.id: node for node in self.nodes}

    @cached_property
    def in_edges(self) -> dict[int, tuple[Edge, ...]]:
        """Edges into each node, all kinds, in edge order."""
        return _group(self, incoming=True)

    @cached_property
    def out_edges(self) -> dict[int, tuple[Edge, ...]]:
        """Edges out of each node, all kinds, in edge order."""
        return _group(self, incoming=False)

    @cached_property
    def operations(self) -> tuple[Node, ...]:
        """Nodes that take an FU issue slot."""
        return tuple(node for node in self.nodes if node.uses_fu)

    @cached_property
    def placed(self) -> tuple[Node, ...]:
        """Nodes that a mapping places: operations and live-outs."""
        return tuple(node for node in self.nodes if not node.is_source)

    def routed_edges(self) -> Iterator[tuple[int, Edge]]:
        """(index, edge) of each data edge between placed nodes: the ones that need a route."""
        for index, edge in enumerate(self.edges):
            if edge.is_data and not self.by_id[edge.src].is_source:
                yield index, edge

    def operand(self, node_id: int, port: int) -> Edge | None:
        """The edge into `port`, or None."""
        for edge in self.in_edges[node_id]:
            if edge.port == port and edge.is_data:
                return edge
        return None

    if TYPE_CHECKING:  # attached by `draw`: pictures are made of graphs

        def plot(self, path: str | Path | None = None) -> Picture:
            """Draw the graph in layers."""

        def _repr_svg_(self) -> str:
            """The picture that a notebook shows."""

    def next_id(self) -> int:
        """An id larger than all in use."""
        return max((node.id for node in self.nodes), default=-1) + 1


def is_order(edge: Edge) -> bool:
    """Whether the edge separates two nodes without carrying a word."""
    return edge.port == ORDER


def _group(dfg: DFG, *, incoming: bool) -> dict[int, tuple[Edge, ...]]:
    groups: dict[int, list[Edge]] = {node.id: [] for node in dfg.nodes}
    for edge in dfg.edges:
        groups[edge.dst if incoming else edge.src].append(edge)
    return {key: tuple(value) for key, value in groups.items()}
