"""Collects nodes and edges of one DFG; loop-carried values are placeholders until the body is
known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import InternalError, SourceLoc
from vividc.host import time_limit
from vividc.host.once import changed
from vividc.machine.compare import INVERSES
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import BASE, ORDER, PRED, SOURCES, Opcode


@dataclass(frozen=True, slots=True)
class Operand:
    """A word of the graph: the result of `node`, or (negative ids) the value of a loop phi."""

    node: int

    @property
    def is_phi(self) -> bool:
        """Stands for the previous iteration's value until `close_phi` names it."""
        return self.node < 0


class GraphBuilder:
    """Grows one DFG. Node ids are dense and in creation order."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._nodes: list[Node] = []
        self._edges: list[Edge] = []
        self._operands: dict[int, tuple[Operand, ...]] = {}
        self._sources: dict[tuple[Opcode, int | str | None], Operand] = {}
        self._phis: dict[int, tuple[Operand, Operand]] = {}
        self._next_phi = -1

    def const(self, word: int) -> Operand:
        """The constant `word`."""
        return self._source(Opcode.CONST, word & 0xFFFFFFFF)

    def live_in(self, name: str) -> Operand:
        """The input or variable `name`."""
        return self._source(Opcode.LIVE_IN, name)

    def iv(self) -> Operand:
        """The iteration index."""
        return self._source(Opcode.IV, None)

    def node(self, operand: Operand) -> Node | None:
        """The node behind an operand; None for a phi."""
        return None if operand.is_phi else self._nodes[operand.node]

    def is_constant(self, operand: Operand, word: int) -> bool:
        """Whether `operand` is the constant `word`."""
        node = self.node(operand)
        return node is not None and node.op is Opcode.CONST and node.const == word

    def add(
        self,
        op: Opcode,
        operands: Sequence[Operand],
        loc: SourceLoc | None = None,
        lane: Lane | None = None,
    ) -> Operand:
        """A new node of `op` fed by `operands` on ports 0, 1, ..."""
        return self.add_node(Node(len(self._nodes), op, loc=loc, lane=lane), operands)

    def add_node(
        self,
        node: Node,
        operands: Sequence[Operand],
        pred: Operand | None = None,
        base: Operand | None = None,
    ) -> Operand:
        """`node` under an id of this graph, fed by `operands`, by `pred` and by `base`."""
        ident = len(self._nodes)
        self._nodes.append(node if node.id == ident else changed(node, id=ident))
        ports = list(enumerate(operands))
        ports += [(PRED, pred)] if pred is not None else []
        ports += [(BASE, base)] if base is not None else []
        self._edges.extend(Edge(operand.node, ident, port) for port, operand in ports)
        self._operands[ident] = tuple(operands)
        time_limit.step("regions were built")
        return Operand(ident)

    def fixed_base(
        self, base: Operand, index: Operand, shift: int, loc: SourceLoc | None = None
    ) -> tuple[Operand, Operand, int]:
        """(base, index, shift) of the same address with a base that is a constant or a live-in: a
        load/store unit takes no other.
        """
        node = self.node(base)
        if node is not None and node.op in (Opcode.CONST, Opcode.LIVE_IN):
            return base, index, shift
        scaled = self.add(Opcode.SHL, [index, self.const(shift)], loc) if shift else index
        return self.const(0), self.add(Opcode.ADD, [base, scaled], loc), 0

    def operation(self, operand: Operand, loc: SourceLoc | None = None) -> Operand:
        """`operand` if an FU computes it, else a `mov` of it."""
        node = self.node(operand)
        if node is None or node.op in SOURCES:
            return self.add(Opcode.MOV, [operand], loc)
        return operand

    def invert(self, operand: Operand) -> Operand:
        """The predicate that is 1 where `operand` is 0; a comparison is inverted by its opcode."""
        node = self.node(operand)
        inverse = INVERSES.get(node.op) if node is not None else None
        if node is None or inverse is None:
            return self.add(Opcode.XOR, [operand, self.const(1)])
        left, right = self._operands[node.id]
        pair = [right, left] if inverse[1] else [left, right]
        return self.add(inverse[0], pair, node.loc)

    def mark(self, operand: Operand, control: Control, loc: SourceLoc | None = None) -> Operand:
        """Hands `operand` to the tile controller (through a `mov` where it is not an operation)."""
        target = self.operation(operand, loc)
        node = self._nodes[target.node]
        if node.control is not None:
            target = self.add(Opcode.MOV, [target], loc)
            node = self._nodes[target.node]
        self._nodes[target.node] = replace(node, control=control)
        return target

    def order(
        self, before: Operand, after: Operand, distance: int, *, assumed: bool = False
    ) -> None:
        """Two memory operations that must keep their order; `assumed` as of `Edge`."""
        self._edges.append(
            Edge(before.node, after.node, ORDER, distance, kind=EdgeKind.ORDER, assumed=assumed)
        )

    def control(self, exit_node: Operand, effect: Operand, distance: int) -> None:
        """An effect that must wait for the exit decision."""
        self._edges.append(
            Edge(exit_node.node, effect.node, ORDER, distance, kind=EdgeKind.CONTROL)
        )

    def open_phi(self) -> Operand:
        """A loop-carried value whose source is not known yet."""
        operand = Operand(self._next_phi)
        self._next_phi -= 1
        return operand

    def close_phi(self, phi: Operand, initial: Operand, carried: Operand) -> None:
        """`phi` is `initial` in iteration 0 and the last iteration's `carried` afterwards."""
        if carried == phi:
            self._phis[phi.node] = (initial, initial)
        else:
            self._phis[phi.node] = (initial, self.operation(carried))

    def build(self) -> DFG:
        """The finished graph."""
        return DFG(self.name, tuple(self._nodes), tuple(map(self._resolve, self._edges)))

    def _resolve(self, edge: Edge) -> Edge:
        if edge.src >= 0:
            return edge
        if edge.src not in self._phis:
            raise InternalError(f"region {self.name}: a loop-carried value has no source")
        initial, carried = self._phis[edge.src]
        if carried == initial:
            return replace(edge, src=initial.node)
        return replace(edge, src=carried.node, distance=1, init=initial.node)

    def _source(self, op: Opcode, key: int | str | None) -> Operand:
        if (op, key) not in self._sources:
            const = key if isinstance(key, int) else None
            name = key if isinstance(key, str) else ""
            self._sources[op, key] = Operand(len(self._nodes))
            self._nodes.append(Node(len(self._nodes), op, const, name))
        return self._sources[op, key]
