"""Brings variables to the PEs that read them: between the regions of a kernel, words travel by
live-out writes.

Straight regions write each variable to all its homes (`homes`), and read it through a `mov` on one
of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vividc.arch.fabric import Fabric
from vividc.compiler.regions.stores import Homes, Residents
from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.regions import Region, is_variable
from vividc.machine.opcodes import BASE, Opcode
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import dependences, earliest_starts


@dataclass(frozen=True)
class Delivery:
    """A straight region ready to be mapped: its graph with deliveries, and where they must lie."""

    dfg: DFG
    allowed: Mapping[int, frozenset[int]]


def deliver(region: Region, homes: Homes, fabric: Fabric, held: Residents) -> Delivery:
    """`region`'s graph with a live-out for each home of each variable written, and a `mov` for
    each variable read but by one operation alone that can lie where the variable does.

    Parameters
    ----------
    held
        Entries of the constant stores that are taken, those of the variables among them.
    """
    edit = _Edit(region.dfg, homes, fabric, held)
    for node in region.dfg.nodes:
        edit.add(node)
    return Delivery(edit.finish(), edit.allowed)


class _Edit:
    """Copies a straight region's graph, node by node."""

    def __init__(self, dfg: DFG, homes: Homes, fabric: Fabric, held: Residents) -> None:
        self.dfg = dfg
        self.homes = homes
        self.fabric = fabric
        self.problem = MapProblem(dfg, fabric)
        self.held = {pe.id: held.get(pe.id, frozenset()) for pe in fabric.pes}
        self.crowded = _is_crowded(dfg, fabric)
        self.nodes: list[Node] = []
        self.extra: list[Edge] = []
        self.dropped: set[int] = set()
        self.allowed: dict[int, frozenset[int]] = {}
        self.reader: dict[int, int] = {}
        self._next = dfg.next_id()

    def add(self, node: Node) -> None:
        """Copies one node with what it needs."""
        if node.op is Opcode.LIVE_IN and is_variable(node.name):
            self._add_reader(node)
        elif node.op is Opcode.LIVE_OUT:
            self._add_writers(node)
        else:
            self.nodes.append(node)

    def finish(self) -> DFG:
        """The edited graph."""
        edges = []
        for edge in self.dfg.edges:
            if edge.dst in self.dropped:
                continue
            through = self.reader.get(edge.src)
            if through is not None and edge.port != BASE and not self._is_reader_itself(edge):
                edge = replace(edge, src=through)  # noqa: PLW2901 - the edited copy
            edges.append(edge)
        return DFG(self.dfg.name, tuple(self.nodes), (*edges, *self.extra))

    def _is_reader_itself(self, edge: Edge) -> bool:
        return self.reader.get(edge.src) == edge.dst

    def _add_reader(self, node: Node) -> None:
        self.nodes.append(node)
        consumers = self.dfg.out_edges[node.id]
        movs = [e.dst for e in consumers if self.dfg.by_id[e.dst].op is Opcode.MOV]
        if movs:
            self.reader[node.id] = movs[0]
            self.allowed[movs[0]] = self.homes[node.name]
            return
        if all(edge.port == BASE for edge in consumers) or self._is_read_at_home(node):
            return
        mov = Node(self._fresh(), Opcode.MOV, loc=node.loc)
        self.nodes.append(mov)
        self.extra.append(Edge(node.id, mov.id, 0))
        self.reader[node.id] = mov.id
        self.allowed[mov.id] = self.homes[node.name]

    def _is_read_at_home(self, variable: Node) -> bool:
        """Whether one operation alone reads the variable, and is to lie in one of its homes: it
        waits for no other operation, and what else it reads lies there, too, or a link away, so
        that it can begin as early as it could anywhere; that matters less where operations wait
        for PEs.
        """
        edges = self.dfg.out_edges[variable.id]
        reader = self.dfg.by_id[edges[0].dst]
        operands = [self.dfg.by_id[edge.src] for edge in self.dfg.in_edges[reader.id]]
        if len(edges) > 1 or reader.op is Opcode.LIVE_OUT:
            return False
        if not all(operand.is_source for operand in operands):
            return False
        others = {node.name for node in operands if is_variable(node.name)} - {variable.name}
        pes = self.allowed.get(reader.id, frozenset(self.fabric.hosts(reader)))
        keys = frozenset(self.problem.constants_of(reader))
        shared = frozenset(
            pe
            for pe in pes & self.homes[variable.name]
            if len(self.held[pe] | keys) <= self.fabric.pes[pe].constants
            if self.crowded or all(self._around(pe) & self.homes[other] for other in others)
        )
        if not shared:
            return False
        self.allowed[reader.id] = shared
        for pe in shared:  # it has room there, whatever else does
            self.held[pe] |= keys
        return True

    def _around(self, pe: int) -> frozenset[int]:
        """The PE and those that its links lead from."""
        return frozenset({pe, *(link.src for link in self.fabric.links_to[pe])})

    def _add_writers(self, node: Node) -> None:
        homes = sorted(self.homes.get(node.name, ()))
        if not homes:
            self.dropped.add(node.id)
            return
        edge = next(edge for edge in self.dfg.in_edges[node.id] if edge.is_data)
        for number, pe in enumerate(homes):
            ident = node.id if number == 0 else self._fresh()
            self.nodes.append(replace(node, id=ident))
            self.allowed[ident] = frozenset({pe})
            if number > 0:
                self.extra.append(replace(edge, dst=ident, src=self.reader.get(edge.src, edge.src)))

    def _fresh(self) -> int:
        self._next += 1
        return self._next - 1


def _is_crowded(dfg: DFG, fabric: Fabric) -> bool:
    """Whether operations and moves of what they read take longer than the longest path."""
    moved = sum(node.op is Opcode.LIVE_IN and is_variable(node.name) for node in dfg.nodes)
    starts = earliest_starts([n.id for n in dfg.placed], dependences(dfg, fabric), 1) or {}
    return len(dfg.operations) + moved > len(fabric.pes) * (1 + max(starts.values(), default=0))
