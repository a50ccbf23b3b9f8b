"""Hypothesis strategies for dataflow graphs: executable loops, and small foreign graphs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from hypothesis import strategies as st

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import SourceLoc
from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import BASE, ELEMENTARY, LANE_TYPES, OPCODES, ORDER, PRED, Opcode, Type
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import word_of

ARRAY_WORDS = 16
WORD_BYTES = 4
ARRAYS = ("x", "y")
BASES = {"&x": 0, "&y": 4 * ARRAY_WORDS}
MEMORY_WORDS = len(ARRAYS) * ARRAY_WORDS
INPUTS = ("n", "a")

_INTEGERS = (0, 1, 2, 3, 31, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
_FLOATS = tuple(map(word_of, (0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 3.25, -7.75, 1e-40, 1e30, 0.1)))
_LANES = tuple(op for op in SEMANTICS if op in LANE_SEMANTICS)
_OPERATIONS = tuple(op for op in SEMANTICS if op not in ELEMENTARY and op not in LANE_SEMANTICS)
_COMPARISONS = tuple(op for op in SEMANTICS if OPCODES[op].result is Type.PRED)
_GUARDED = (Opcode.ADD, Opcode.SUB, Opcode.SMAX, Opcode.FADD, Opcode.FSUB, Opcode.FMA, Opcode.SHL)


def words() -> st.SearchStrategy[int]:
    """Words that mean something as an integer or as a float; no NaN with a payload."""
    return st.sampled_from(_INTEGERS[:6] + _FLOATS) | st.integers(0, 40)


@dataclass
class _Builder:
    """A graph under construction: values are ids of nodes with a result, by type."""

    draw: st.DrawFn
    nodes: list[Node] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    last_access: dict[str, list[int]] = field(default_factory=dict)

    def node(self, op: Opcode, **fields: object) -> int:
        loc = SourceLoc("kernel.py", len(self.nodes) + 1)
        self.nodes.append(Node(len(self.nodes), op, loc=loc, **fields))  # type: ignore[arg-type]
        return self.nodes[-1].id

    def constant(self, word: int) -> int:
        return self.node(Opcode.CONST, const=word)

    def feed(self, src: int, dst: int, port: int) -> None:
        self.edges.append(Edge(src, dst, port))

    def of_type(self, wanted: Type) -> list[int]:
        """Nodes whose result may feed a port of this type; only true predicates are predicates."""
        return [node.id for node in self.nodes if _fits(node, wanted)]

    def pick(self, wanted: Type) -> int:
        choices = self.of_type(wanted)
        return self.draw(st.sampled_from(choices)) if choices else self.constant(1)

    def operation(self, op: Opcode) -> int:
        operands = [self.pick(wanted) for wanted in OPCODES[op].operands]
        node_id = self.node(op)
        for port, src in enumerate(operands):
            self.feed(src, node_id, port)
        self.predicate(node_id, OPCODES[op].operands[-1])
        return node_id

    def predicate(self, node_id: int, passed: Type) -> None:
        """Perhaps predicate a node; one that passes another type on would break its readers."""
        preds = [pred for pred in self.of_type(Type.PRED) if pred != node_id]
        result = self.nodes[node_id].info.result
        if preds and result in (passed, Type.NONE) and self.draw(st.integers(0, 3)) == 0:
            self.feed(self.draw(st.sampled_from(preds)), node_id, PRED)

    def guarded(self) -> None:
        """`select(p, op(.., x), x)` in all its variants; x may be the select's own earlier word."""
        pred = self.operation(self.draw(st.sampled_from(_COMPARISONS)))
        op = self.draw(st.sampled_from(_GUARDED))
        node_id = self.operation(op)
        port = self.draw(st.sampled_from((0, OPCODES[op].arity - 1)))
        at = next(i for i, e in enumerate(self.edges) if (e.dst, e.port) == (node_id, port))
        kept = self.edges[at]
        if self.draw(st.booleans()):
            init = self.constant(self.draw(words()))
            kept = Edge(len(self.nodes), node_id, port, 1, init)
            self.edges[at] = kept
        select = self.node(Opcode.SELECT)
        arms = [Edge(node_id, select, 0), replace(kept, dst=select)]
        self.feed(pred, select, 0)
        for arm, edge in enumerate(self.draw(st.permutations(arms)), start=1):
            self.edges.append(replace(edge, port=arm))

    def extremum(self) -> None:
        """A select between the sides of a comparison, of which one may be a constant."""
        comparison = self.draw(st.sampled_from(_COMPARISONS))
        wanted = OPCODES[comparison].operands[0]
        sides = [self.pick(wanted), self.constant(self.draw(words()))]
        pred, select = self.node(comparison), self.node(Opcode.SELECT)
        self.feed(pred, select, 0)
        for node_id, first in ((pred, 0), (select, 1)):
            for port, src in enumerate(self.draw(st.permutations(sides)), start=first):
                self.feed(src, node_id, port)

    def product(self) -> None:
        """A product that an addition or subtraction reads."""
        product = self.operation(Opcode.FMUL)
        addend = self.pick(Type.F32)
        total = self.node(self.draw(st.sampled_from((Opcode.FADD, Opcode.FSUB))))
        for port, src in enumerate(self.draw(st.permutations((product, addend)))):
            self.feed(src, total, port)
        self.predicate(total, Type.F32)

    def memory(self, op: Opcode) -> int:
        array = self.draw(st.sampled_from(ARRAYS))
        index, mask = self.pick(Type.I32), self.constant(ARRAY_WORDS - 1)
        masked = self.node(Opcode.AND)
        self.feed(index, masked, 0)
        self.feed(mask, masked, 1)
        value = self.pick(Type.ANY) if op is Opcode.STORE else None
        width = self.draw(st.sampled_from((4, 4, 1, 2)))
        signed = op is Opcode.LOAD and width < WORD_BYTES and self.draw(st.booleans())
        shift = width.bit_length() - 1
        node_id = self.node(op, name=array, shift=shift, width=width, signed=signed)
        self.feed(self.live_in(f"&{array}"), node_id, BASE)
        self.feed(masked, node_id, 0)
        if value is not None:
            self.feed(value, node_id, 1)
        preds = self.of_type(Type.PRED)
        if preds and self.draw(st.booleans()):
            self.feed(self.draw(st.sampled_from(preds)), node_id, PRED)
        self.order(node_id, array)
        return node_id

    def order(self, node_id: int, array: str) -> None:
        """Every pair of accesses to one array, one of which stores, in both iterations' order."""
        earlier = self.last_access.setdefault(array, [])
        for other in earlier:
            if Opcode.STORE in (self.nodes[node_id].op, self.nodes[other].op):
                self.edges.append(Edge(other, node_id, ORDER, kind=EdgeKind.ORDER))
                self.edges.append(Edge(node_id, other, ORDER, 1, kind=EdgeKind.ORDER))
        if self.nodes[node_id].op is Opcode.STORE:
            self.edges.append(Edge(node_id, node_id, ORDER, 1, kind=EdgeKind.ORDER))
        earlier.append(node_id)

    def live_in(self, name: str) -> int:
        known = [n.id for n in self.nodes if n.op is Opcode.LIVE_IN and n.name == name]
        return known[0] if known else self.node(Opcode.LIVE_IN, name=name)

    def carry(self, source: int, init: int) -> None:
        """Let some operands read the value of the iteration before."""
        readers = [
            index
            for index, edge in enumerate(self.edges)
            if edge.is_data and edge.port != BASE and self.may_carry(edge, source, init)
        ]
        if not readers:
            return
        chosen = self.draw(st.sampled_from(readers))
        old = self.edges[chosen]
        self.edges[chosen] = Edge(source, old.dst, old.port, 1, init)

    def may_carry(self, edge: Edge, source: int, init: int) -> bool:
        reader = self.nodes[edge.dst]
        # An index must stay masked.
        if edge.distance or reader.op is Opcode.AND or (reader.is_memory and edge.port == 0):
            return False
        wanted = Type.PRED if edge.port == PRED else reader.info.operands[edge.port]
        given = self.nodes[source]
        word = self.nodes[init].const
        return _fits(given, wanted) and not (wanted is Type.PRED and word not in (0, 1))


def _fits(node: Node, wanted: Type) -> bool:
    given = node.info.result
    if given is Type.NONE:
        return False
    if wanted is Type.PRED:
        return given is Type.PRED
    if wanted is Type.F32 or wanted in LANE_TYPES:
        return given in (wanted, Type.ANY) and node.op not in (Opcode.MOV, Opcode.SELECT)
    if wanted is Type.I32:
        return given in (Type.I32, Type.PRED) or node.op is Opcode.CONST
    return True


@st.composite
def dfgs(draw: st.DrawFn, max_operations: int = 10) -> DFG:
    """Executable loop graphs: well-typed operations, recurrences, accesses inside two small arrays.

    The graph reads the live-ins `INPUTS` and `BASES`, writes variables %v0, %v1, ..., and perhaps
    has an exit node. `check` accepts it.
    """
    builder = _Builder(draw)
    builder.node(Opcode.IV)
    for name in INPUTS:
        builder.node(Opcode.LIVE_IN, name=name)
    for word in draw(st.lists(words(), min_size=1, max_size=4)):
        builder.constant(word)
    for _ in range(draw(st.integers(1, max_operations))):
        _add_operations(builder)
    _add_recurrences(builder)
    _add_effects(builder)
    return DFG("random", tuple(builder.nodes), tuple(builder.edges))


def _add_operations(builder: _Builder) -> None:
    """One operation, or one of the idioms that passes look for."""
    kinds = ("operation",) * 6 + ("load", "store", "guarded", "extremum", "product", "lanes")
    kind = builder.draw(st.sampled_from(kinds))
    if kind == "operation":
        builder.operation(builder.draw(st.sampled_from(_OPERATIONS)))
    elif kind == "lanes":
        builder.operation(builder.draw(st.sampled_from(_LANES)))
    elif kind in ("load", "store"):
        builder.memory(Opcode(kind))
    else:
        {"guarded": builder.guarded, "extremum": builder.extremum, "product": builder.product}[
            kind
        ]()


def _add_recurrences(builder: _Builder) -> None:
    operations = [n.id for n in builder.nodes if n.uses_fu and n.info.result is not Type.NONE]
    if not operations:
        return
    for _ in range(builder.draw(st.integers(0, 3))):
        source = builder.draw(st.sampled_from(operations))
        is_pred = builder.nodes[source].info.result is Type.PRED
        word = builder.draw(st.integers(0, 1) if is_pred else words())
        builder.carry(source, builder.constant(word))


def _add_effects(builder: _Builder) -> None:
    draw = builder.draw
    results = [n.id for n in builder.nodes if n.uses_fu and n.info.result is not Type.NONE]
    if not results:
        return
    for index, source in enumerate(
        draw(st.lists(st.sampled_from(results), min_size=1, max_size=3))
    ):
        builder.feed(source, builder.node(Opcode.LIVE_OUT, name=f"%v{index}"), 0)
    exits = [n for n in builder.nodes if n.info.result is Type.PRED and n.uses_fu]
    if exits and draw(st.booleans()):
        _add_exit(builder, draw(st.sampled_from(exits)).id)


def _add_exit(builder: _Builder, exit_id: int) -> None:
    """Mark the exit node, and the effects that it does not depend on as it pleases."""
    nodes = builder.nodes
    old = nodes[exit_id]
    nodes[exit_id] = Node(old.id, old.op, loc=old.loc, control=Control.EXIT)
    before = _ancestors(builder, exit_id)
    for node in list(nodes):
        if node.op not in (Opcode.STORE, Opcode.LIVE_OUT):
            continue
        unless = node.id not in before and builder.draw(st.booleans())
        if unless:
            nodes[node.id] = replace(node, unless_exit=True)
        distance = 0 if unless else 1
        control = Edge(exit_id, node.id, ORDER, distance, kind=EdgeKind.CONTROL)
        builder.edges.append(control)


def _ancestors(builder: _Builder, node_id: int) -> set[int]:
    found = {node_id}
    pending = [node_id]
    while pending:
        current = pending.pop()
        for edge in builder.edges:
            if edge.dst == current and not edge.distance and edge.src not in found:
                found.add(edge.src)
                pending.append(edge.src)
    return found


@st.composite
def foreign_dfgs(draw: st.DrawFn, max_nodes: int = 5, max_distance: int = 2) -> DFG:
    """Connected graphs of `generic` nodes, some with recurrences, for mappers; not executable."""
    count = draw(st.integers(1, max_nodes))
    nodes = tuple(Node(index, Opcode.GENERIC, name="op") for index in range(count))
    edges: list[Edge] = []
    for dst in range(1, count):
        for src in sorted(draw(st.sets(st.integers(0, dst - 1), min_size=1, max_size=2))):
            _append_edge(edges, src, dst, 0)
    for _ in range(draw(st.integers(0, 2))):
        src = draw(st.integers(0, count - 1))
        dst = draw(st.integers(0, src))
        _append_edge(edges, src, dst, draw(st.integers(1, max_distance)))
    return DFG("foreign", nodes, tuple(edges))


def _append_edge(edges: list[Edge], src: int, dst: int, distance: int) -> None:
    port = sum(edge.dst == dst for edge in edges)
    if port < PRED:
        edges.append(Edge(src, dst, port, distance))
