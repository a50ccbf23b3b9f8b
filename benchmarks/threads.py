"""Blending of several pixels of a row at once: the inner loop of `kernels/gs_blend.py` as graphs of
four and eight threads that share what does not depend on the column.

`python -m benchmarks.threads` maps them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import click

import vividc
from benchmarks.workloads import WORKLOADS
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.ir import DFG, Control, Edge, Node
from vividc.dfg.pipeline import PassOptions, pipeline
from vividc.frontend import KernelFunction
from vividc.machine.opcodes import PRED, Opcode
from vividc.mapper import map_dfg

HEADER: Final = (
    "| threads | fabric | operations | II | bound | status | seconds |\n"
    "|---|---|---|---|---|---|---|"
)
CASES: Final = (
    (4, "vivid-tile-unit", 10.0),
    (4, "mesh-4x4", 10.0),
    (8, "mesh-8x8", 30.0),
)
"""Threads, fabric and the seconds they may take."""
_FALSE: Final = 0


def blend() -> DFG:
    """The loop of one thread. exp is one operation, as a function unit of its own does it, instead
    of the 14 that it expands to.
    """
    kernel = next(item for item in WORKLOADS if item.name == "gs_blend").kernel()
    assert isinstance(kernel, KernelFunction)
    regions = build_kernel(kernel.lower()).regions
    graph = next(region.dfg for region in regions if region.kind == "loop")
    for step in pipeline(PassOptions()):
        graph = graph if step is expand_math else step(graph)
    nodes = (
        replace(node, op=Opcode.GENERIC, name="exp") if node.op is Opcode.EXP else node
        for node in graph.nodes
    )
    return replace(graph, nodes=tuple(nodes))


def threads(count: int) -> DFG:
    """The loop of `count` pixels of one row, which ends when the last of them is opaque.

    Loads are shared, so they are not predicated; a thread that is done before the others is masked.
    """
    return _Jam(blend(), count).graph()


class _Jam:
    """Copies of a loop side by side.

    Thread 0 keeps its ids. What a thread would do at the exit, `done` remembers for it: the word
    of the exit node or that of the iteration before. An effect takes place where its predicate
    is above `done`, and the tile exits when all are done.
    """

    def __init__(self, one: DFG, count: int) -> None:
        self.one, self.count = one, count
        self.nodes: list[Node] = [_unpredicated(node) for node in one.nodes]
        self.edges: list[Edge] = []
        self.exit = next(node for node in one.nodes if node.control is Control.EXIT)
        self.own = _depending_on_column(one)
        self.free = max(node.id for node in one.nodes) + 1

    def graph(self) -> DFG:
        """All threads, and the exit of the tile."""
        false = self._new(Opcode.CONST, const=_FALSE)
        done = [self._thread(self._copies(thread), false) for thread in range(self.count)]
        every = done[0]
        for other in done[1:]:
            every = self._new(Opcode.AND, every, other)
        self._change(every, control=Control.EXIT)
        live_outs = {node.id for node in self.nodes if node.op is Opcode.LIVE_OUT}
        control = next(edge for edge in self.one.edges if edge.src == self.exit.id)
        self.edges += [replace(control, src=every, dst=node) for node in sorted(live_outs)]
        name = f"{self.one.name}, {self.count} threads"
        return DFG(name, tuple(self.nodes), tuple(self.edges))

    def _copies(self, thread: int) -> dict[int, int]:
        """Ids of the nodes of one thread."""
        ids = {node.id: node.id for node in self.one.nodes}
        if thread == 0:
            return ids
        for node in self.one.nodes:
            if node.id in self.own:
                ids[node.id] = self.free
                name = f"{node.name}.{thread}" if _is_named(node) else node.name
                self.nodes.append(replace(_unpredicated(node), id=self.free, name=name))
                self.free += 1
        return ids

    def _thread(self, ids: dict[int, int], false: int) -> int:
        """Edges of one thread; its `done`."""
        done = self._new(Opcode.OR, ids[self.exit.id])
        self.edges.append(Edge(done, done, 1, 1, false))
        self._change(ids[self.exit.id], control=None)
        masks: dict[int, int] = {}
        first = ids[self.exit.id] == self.exit.id
        for edge in self.one.edges:
            shared = edge.dst not in self.own
            if not edge.is_data or (shared and not first):
                continue
            by_id = self.one.by_id
            if edge.port == PRED and by_id[edge.dst].op is Opcode.LOAD:
                continue
            init = None if edge.init is None else ids[edge.init]
            src = ids[edge.src]
            if edge.port == PRED and _is_carried(self.one, edge.dst):
                if src not in masks:
                    masks[src] = self._new(Opcode.ICMP_ULT, done, src)
                src = masks[src]
            self.edges.append(replace(edge, src=src, dst=ids[edge.dst], init=init))
        return done

    def _new(self, op: Opcode, *operands: int, const: int | None = None) -> int:
        node = self.free
        self.free += 1
        self.nodes.append(Node(node, op, const=const))
        self.edges += [Edge(src, node, port) for port, src in enumerate(operands)]
        return node

    def _change(self, ident: int, *, control: Control | None) -> None:
        self.nodes = [
            replace(node, control=control) if node.id == ident else node for node in self.nodes
        ]


def _is_named(node: Node) -> bool:
    return node.op in (Opcode.LIVE_IN, Opcode.LIVE_OUT)


def _unpredicated(node: Node) -> Node:
    """Loads take place in every iteration."""
    return replace(node, unless_exit=False) if node.op is Opcode.LOAD else node


def _is_carried(graph: DFG, node: int) -> bool:
    return any(edge.distance for edge in graph.in_edges[node] if edge.src == node)


def _depending_on_column(graph: DFG) -> frozenset[int]:
    """Nodes of a thread of its own: what is computed from the pixel's x, and what is carried."""
    x = next(
        edge.src
        for load in graph.nodes
        if load.name == "mean_x" and load.op is Opcode.LOAD
        for user in graph.out_edges[load.id]
        for edge in graph.in_edges[user.dst]
        if graph.by_id[edge.src].op is Opcode.LIVE_IN
    )
    own = {x}
    waiting = [x]
    while waiting:
        for edge in graph.out_edges[waiting.pop()]:
            node = graph.by_id[edge.dst]
            if edge.is_data and edge.dst not in own and node.op is not Opcode.LOAD:
                own.add(edge.dst)
                waiting.append(edge.dst)
    inits = {edge.init for edge in graph.edges if edge.dst in own and edge.init is not None}
    return frozenset(own | {i for i in inits if graph.by_id[i].op is Opcode.LIVE_IN})


def rows(cases: tuple[tuple[int, str, float], ...] = CASES) -> Iterator[str]:
    """One line for each number of threads and fabric."""
    for count, fabric, time_limit_s in cases:
        graph = threads(count)
        result = map_dfg(graph, vividc.arch.load(fabric), time_limit_s=time_limit_s)
        ii = "-" if result.ii is None else result.ii
        outcome = f"{ii} | {result.lower_bound} | {result.status} | {result.wall_s:.1f}"
        yield f"| {count} | {fabric} | {len(graph.operations)} | {outcome} |"


@click.command()
def main() -> None:
    """Print the table."""
    click.echo(HEADER)
    for line in rows():
        click.echo(line)


if __name__ == "__main__":
    main()
