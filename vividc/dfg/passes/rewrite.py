"""A DFG being edited by a pass: nodes and edges by key, with the graph rebuilt only if something
changed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import SourceLoc
from vividc.host import time_limit
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import BASE, PRED, Opcode, Type, never_meet

_INIT_SOURCES = frozenset({Opcode.CONST, Opcode.LIVE_IN})


class Value(NamedTuple):
    """What an operand reads: node `src`, `distance` iterations ago, `init` before there was one."""

    src: int
    distance: int = 0
    init: int | None = None


def value_of(edge: Edge) -> Value:
    """What a data edge reads."""
    return Value(edge.src, edge.distance, edge.init)


class Rewrite:
    """The editable copy of a graph. Edges keep their order; new nodes and edges come last."""

    def __init__(self, dfg: DFG) -> None:
        self._dfg = dfg
        self.nodes: dict[int, Node] = dict(dfg.by_id)
        self._edges: dict[int, Edge] = dict(enumerate(dfg.edges))
        self._next_edge = len(dfg.edges)
        self._next_node = dfg.next_id()
        self._into: dict[int, dict[int, None]] = {node.id: {} for node in dfg.nodes}
        self._out: dict[int, dict[int, None]] = {node.id: {} for node in dfg.nodes}
        self._port: dict[int, dict[int, int]] = {node.id: {} for node in dfg.nodes}
        """Key of the data edge into each port."""
        self._changed = False
        self._constants: dict[int, int] | None = None
        """Their nodes by word; None: not known."""
        for key, edge in self._edges.items():  # as `_link`
            self._into[edge.dst][key] = None
            self._out[edge.src][key] = None
            if edge.kind is EdgeKind.DATA:
                self._port[edge.dst].setdefault(edge.port, key)

    def result(self) -> DFG:
        """The edited graph; the original object if nothing changed."""
        if not self._changed:
            return self._dfg
        return DFG(self._dfg.name, tuple(self.nodes.values()), tuple(self._edges.values()))

    def in_edges(self, node_id: int) -> list[Edge]:
        """Edges into a node, all kinds."""
        return [self._edges[key] for key in self._into[node_id]]

    def out_edges(self, node_id: int) -> list[Edge]:
        """Edges out of a node, all kinds."""
        return [self._edges[key] for key in self._out[node_id]]

    def uses(self, node_id: int) -> list[Edge]:
        """Data edges out of a node."""
        return [edge for edge in self.out_edges(node_id) if edge.is_data]

    def edge(self, node_id: int, port: int) -> Edge | None:
        """The data edge into `port`, if any."""
        key = self._port[node_id].get(port)
        return None if key is None else self._edges[key]

    def operand(self, node_id: int, port: int) -> Value:
        """What data port `port` reads; the port is fed."""
        edge = self.edge(node_id, port)
        assert edge is not None, f"nothing feeds port {port} of node {node_id}"
        return value_of(edge)

    def operands(self, node: Node) -> list[Value]:
        """What ports 0, 1, ... read."""
        keys, edges = self._port[node.id], self._edges
        return [value_of(edges[keys[port]]) for port in range(node.info.arity)]

    def predicated(self, node_id: int) -> bool:
        """Whether the node has a predicate."""
        return PRED in self._port[node_id]

    def set_operand(self, node_id: int, port: int, value: Value) -> None:
        """Make `port` read `value`, in the place of the edge that fed it."""
        new = Edge(value.src, node_id, port, value.distance, value.init)
        old = self.edge(node_id, port)
        if old is None:
            self._append(new)
        elif old != new:
            self._replace(self._key(old), new)

    def set_node(self, node: Node) -> None:
        """Change the node of this id."""
        if self.nodes[node.id] != node:
            self._constants = None
            self.nodes[node.id] = node
            self._changed = True

    def add_node(
        self,
        op: Opcode,
        operands: Sequence[Value] = (),
        loc: SourceLoc | None = None,
        lane: Lane | None = None,
    ) -> int:
        """Append an operation that reads `operands` and return its id."""
        return self._append_node(Node(self._next_node, op, loc=loc, lane=lane), operands)

    def constant(self, word: int) -> int:
        """Id of a constant node with this word, an existing one if there is."""
        if self._constants is None:
            words = ((node.const, node.id) for node in reversed(self.nodes.values()))
            self._constants = {known: ident for known, ident in words if known is not None}
        if word in self._constants:
            return self._constants[word]
        return self._append_node(Node(self._next_node, Opcode.CONST, const=word), ())

    def word(self, value: Value) -> int | None:
        """The word of a value that is the same constant in every iteration."""
        word = self.nodes[value.src].const
        if word is None or value.distance == 0:
            return word
        init = None if value.init is None else self.nodes[value.init].const
        return word if init == word else None

    def remove_edge(self, edge: Edge) -> None:
        """Remove one edge equal to `edge`."""
        key = self._key(edge)
        self._unlink(key)
        del self._edges[key]
        self._changed = True

    def add_edge(self, edge: Edge) -> None:
        """Append an edge."""
        self._append(edge)

    def remove_node(self, node_id: int) -> None:
        """Remove a node and all its edges."""
        for key in [*self._into[node_id], *self._out[node_id]]:
            if key in self._edges:
                self._unlink(key)
                del self._edges[key]
        if self.nodes[node_id].const is not None:
            self._constants = None
        del self.nodes[node_id], self._into[node_id], self._out[node_id], self._port[node_id]
        self._changed = True

    def forward(self, node_id: int, value: Value) -> bool:
        """Let the readers of `node_id` read `value` instead; whether any reader changed.

        A reader keeps the node where the graph could not say what it reads: across two carried
        distances, an induction value of an earlier iteration, a live-out of a source, a base
        address that is no source, or a float as a predicate.
        """
        changed = False
        for key in list(self._out[node_id]):
            edge = self._edges[key]
            if not edge.is_data or not self._can_read(edge, value):
                continue
            carried = value if value.distance else Value(value.src, edge.distance, edge.init)
            new = Edge(carried.src, edge.dst, edge.port, carried.distance, carried.init)
            if new != edge:
                self._replace(key, new)
                changed = True
        return changed

    def can_forward(self, node_id: int, value: Value) -> bool:
        """Whether every reader of the node could read `value` instead."""
        return all(self._can_read(edge, value) for edge in self.uses(node_id))

    def replace_init(self, node_id: int, kept: int) -> None:
        """Let every edge that starts with source `node_id` start with `kept`."""
        for key, edge in self._edges.items():
            if edge.init == node_id:
                self._replace(key, replace(edge, init=kept))

    def forward_constant(self, node_id: int, word: int) -> bool:
        """`forward` to a constant, which is made only if some reader can read it."""
        readers = (self.nodes[edge.dst] for edge in self.uses(node_id))
        if all(reader.op is Opcode.LIVE_OUT for reader in readers):
            return False
        return self.forward(node_id, Value(self.constant(word)))

    def _can_read(self, edge: Edge, value: Value) -> bool:
        source, reader = self.nodes[value.src], self.nodes[edge.dst]
        if edge.distance and (value.distance or source.op is Opcode.IV):
            return False
        if reader.op is Opcode.LIVE_OUT and (source.is_source or value.distance):
            return False  # its write port takes this iteration's result only
        if edge.port == BASE and (source.op not in _INIT_SOURCES or value.distance):
            return False
        wanted = _port_type(reader, edge.port)
        return not never_meet(source.info.result, wanted)

    def _append_node(self, node: Node, operands: Iterable[Value]) -> int:
        self.nodes[node.id] = node
        if self._constants is not None and node.const is not None:
            self._constants.setdefault(node.const, node.id)
        self._into[node.id] = {}
        self._out[node.id] = {}
        self._port[node.id] = {}
        self._next_node += 1
        self._changed = True
        for port, value in enumerate(operands):
            self._append(Edge(value.src, node.id, port, value.distance, value.init))
        return node.id

    def _append(self, edge: Edge) -> None:
        self._edges[self._next_edge] = edge
        self._link(self._next_edge)
        self._next_edge += 1
        self._changed = True

    def _replace(self, key: int, edge: Edge) -> None:
        self._unlink(key)
        self._edges[key] = edge
        self._link(key)
        self._changed = True

    def _key(self, edge: Edge) -> int:
        return next(key for key in self._into[edge.dst] if self._edges[key] == edge)

    def _link(self, key: int) -> None:
        edge = self._edges[key]
        self._into[edge.dst][key] = None
        self._out[edge.src][key] = None
        if edge.kind is EdgeKind.DATA:
            self._port[edge.dst].setdefault(edge.port, key)

    def _unlink(self, key: int) -> None:
        edge = self._edges[key]
        del self._into[edge.dst][key]
        del self._out[edge.src][key]
        if self._port[edge.dst].get(edge.port) == key:
            del self._port[edge.dst][edge.port]


def change_operation(rewrite: Rewrite, node: Node, op: Opcode, operands: Sequence[Value]) -> None:
    """Make `node` the operation `op` on `operands`; its predicate, marks and readers stay."""
    for edge in rewrite.in_edges(node.id):
        if edge.is_data and 0 <= edge.port < PRED and edge.port >= len(operands):
            rewrite.remove_edge(edge)
    rewrite.set_node(replace(node, op=op))
    for port, value in enumerate(operands):
        rewrite.set_operand(node.id, port, value)


def to_fixpoint(dfg: DFG, step: Callable[[Rewrite, Node], bool]) -> DFG:
    """Apply `step` to every node, again while one of them changed something.

    `step` returns whether it changed the graph; each change must bring the graph nearer to a form
    that `step` leaves alone.
    """
    rewrite = Rewrite(dfg)
    again = True
    while again:
        again = False
        for node_id in list(rewrite.nodes):
            node = rewrite.nodes.get(node_id)
            if node is not None and step(rewrite, node):
                time_limit.step("regions were optimised")
                again = True
    return rewrite.result()


def _port_type(node: Node, port: int) -> Type:
    if port == PRED:
        return Type.PRED
    return node.info.operands[port] if 0 <= port < node.info.arity else Type.ANY
