"""Random well-formed DFGs, from a seeded generator, for the tests of legality and of optimality."""

from __future__ import annotations

import random
from itertools import pairwise

from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.machine.opcodes import BASE, OPCODES, ORDER, PRED, Opcode

COMPUTE = (Opcode.MOV, Opcode.ADD, Opcode.MUL, Opcode.SELECT)


class _Graph:
    """Nodes and edges under construction."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.nodes: list[Node] = []
        self.edges: list[Edge] = []
        self.results: list[int] = []

    def add(self, op: Opcode, **fields: object) -> int:
        self.nodes.append(Node(len(self.nodes), op, **fields))  # type: ignore[arg-type]
        return len(self.nodes) - 1

    def constant(self) -> int:
        return self.add(Opcode.CONST, const=self.rng.randrange(4))

    def operand(self, reach: int, loose: float) -> int:
        if self.results and self.rng.random() >= loose:
            return self.rng.choice(self.results[-reach:])
        return self.constant()

    def operation(self, op: Opcode, reach: int, loose: float, **fields: object) -> int:
        sources = [self.operand(reach, loose) for _ in range(OPCODES[op].arity)]
        base = self.add(Opcode.LIVE_IN, name="&a") if op in {Opcode.LOAD, Opcode.STORE} else None
        node = self.add(op, **fields)
        self.edges += [Edge(source, node, port) for port, source in enumerate(sources)]
        if base is not None:
            self.edges.append(Edge(base, node, BASE))
        if op is not Opcode.STORE:
            self.results.append(node)
        return node

    def live_out(self, name: str) -> int:
        source = self.rng.choice(self.results)
        node = self.add(Opcode.LIVE_OUT, name=name)
        self.edges.append(Edge(source, node, 0))
        return node

    def order(self, src: int, dst: int, distance: int = 0) -> None:
        self.edges.append(Edge(src, dst, ORDER, distance, kind=EdgeKind.ORDER))

    def build(self, name: str) -> DFG:
        return DFG(name, tuple(self.nodes), tuple(self.edges))


def random_loop(seed: int, size: int, weights: tuple[int, int, int] = (6, 2, 1)) -> DFG:
    """A loop body of `size` placed nodes: recurrences, memory order, live-outs, maybe an exit.

    `weights`: how often computation, memory operations and live-outs occur.
    """
    rng = random.Random(seed)
    graph = _Graph(rng)
    kinds = rng.choices(("compute", "memory", "live_out"), weights, k=size)
    memory: list[int] = []
    effects: list[int] = []
    for kind in kinds:
        if kind == "live_out" and graph.results:
            effects.append(graph.live_out(f"%v{len(graph.nodes)}"))
        elif kind == "memory":
            op = rng.choice((Opcode.LOAD, Opcode.STORE)) if graph.results else Opcode.LOAD
            memory.append(graph.operation(op, 4, 0.2, name="a"))
            effects += [memory[-1]] if op is Opcode.STORE else []
        else:
            graph.operation(rng.choice(COMPUTE), 4, 0.2)
    _carry_some(graph, rng)
    for before, after in pairwise(memory):
        graph.order(before, after)
    if len(memory) > 1 and rng.random() < 0.5:
        graph.order(memory[-1], memory[0], 1)
    if graph.results and rng.random() < 0.25:
        _add_exit(graph, rng, effects)
    return graph.build(f"loop{seed}")


def _carry_some(graph: _Graph, rng: random.Random) -> None:
    """Turn some constant operands into values of the iteration before (or the one before that)."""
    for position, edge in enumerate(graph.edges):
        is_constant = graph.nodes[edge.src].op is Opcode.CONST and edge.port != BASE
        if graph.results and is_constant and rng.random() < 0.5:
            distance = rng.choice((1, 1, 1, 2))
            source = rng.choice(graph.results)
            graph.edges[position] = Edge(source, edge.dst, edge.port, distance, edge.src)


def _add_exit(graph: _Graph, rng: random.Random, effects: list[int]) -> None:
    node = rng.choice(graph.results)
    graph.nodes[node] = Node(
        node, graph.nodes[node].op, name=graph.nodes[node].name, control=Control.EXIT
    )
    for effect in effects:
        graph.edges.append(Edge(node, effect, ORDER, 1, kind=EdgeKind.CONTROL))


def random_region(seed: int, size: int, *, reach: int = 8, memory: float = 0.2) -> DFG:
    """A straight region of `size` placed nodes: predicates, stores, live-outs, a branch."""
    rng = random.Random(seed)
    graph = _Graph(rng)
    ordered: list[int] = []
    for index in range(size):
        kind = rng.random()
        if kind < 0.1 and graph.results:
            graph.live_out(f"%v{index}")
        elif kind < 0.1 + memory:
            op = rng.choice((Opcode.LOAD, Opcode.LOAD, Opcode.STORE)) if ordered else Opcode.LOAD
            ordered.append(graph.operation(op, reach, 0.3, name="a"))
        else:
            graph.operation(rng.choice(COMPUTE), reach, 0.2)
            if len(graph.results) > 1 and rng.random() < 0.1:
                graph.edges.append(Edge(graph.results[-2], graph.results[-1], PRED))
    for before, after in pairwise(ordered):
        if rng.random() < 0.5:
            graph.order(before, after)
    if graph.results:
        last = graph.results[-1]
        op = graph.nodes[last].op
        graph.nodes[last] = Node(last, op, name=graph.nodes[last].name, control=Control.BRANCH)
    return graph.build(f"region{seed}")
