"""A mapper for one PE with plenty of registers: every word waits in registers of its own.

It overlaps iterations as far as one PE can, so that random kernels exercise the engine's stages,
speculation and first-iteration operands without a solver.
"""

from __future__ import annotations

import networkx as nx

from vividc.arch import Fabric, load_text
from vividc.dfg.ir import DFG, Edge, EdgeKind
from vividc.dfg.regions import Region
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Place, Step


def one_pe(latencies: str, control_latency: int, scratchpad_bytes: int = 64) -> Fabric:
    """A 1x1 fabric large enough for any random kernel; `latencies` as in a fabric file."""
    return load_text(
        "extends: mesh-1x1\n"
        f"latencies: {latencies}\n"
        "pe:\n"
        "  register_file: {registers: 256, read_ports: 16, write_ports: 16}\n"
        "  constants: 256\n"
        f"scratchpad: {{size_bytes: {scratchpad_bytes}, banks: 2}}\n"
        f"controller: {{contexts: 4096, control_latency: {control_latency}, max_stages: 256}}\n"
    )


def map_region(region: Region, fabric: Fabric) -> Mapping:
    """Schedule a region at the smallest II that first-come placement reaches."""
    operations = max(len(region.dfg.operations), 1)
    if region.kind == "straight":
        start = _schedule(region.dfg, fabric, 1 << 20)
        ends = [start[n.id] + _separation(region.dfg, fabric, n.id) for n in region.dfg.placed]
        return _mapping(region.dfg, fabric, start, max(ends, default=1))
    ii = operations
    while True:
        start = _schedule(region.dfg, fabric, ii)
        if _carries(region.dfg, fabric, start, ii):
            return _mapping(region.dfg, fabric, start, ii)
        ii += 1


def _separation(dfg: DFG, fabric: Fabric, node: int, kind: EdgeKind = EdgeKind.CONTROL) -> int:
    """Cycles after the start of `node` at which its consequence of this kind is there."""
    producer = dfg.by_id[node]
    if kind is EdgeKind.ORDER or producer.op is Opcode.LIVE_OUT:
        return 1
    extra = fabric.controller.control_latency if kind is EdgeKind.CONTROL else 0
    return fabric.latency(producer) + extra


def _schedule(dfg: DFG, fabric: Fabric, ii: int) -> dict[int, int]:
    """Earliest free slot in topological order; live-outs after every read of their variable."""
    graph = nx.DiGraph()
    graph.add_nodes_from(node.id for node in dfg.placed)
    graph.add_edges_from((e.src, e.dst) for e in _between(dfg) if e.distance == 0)
    order = list(nx.lexicographical_topological_sort(graph))
    order.sort(key=lambda node: dfg.by_id[node].op is Opcode.LIVE_OUT)
    start: dict[int, int] = {}
    issue: set[int] = set()
    complete: set[int] = set()
    capture: set[int] = set()
    for node in order:
        before = [e for e in _between(dfg) if e.dst == node and e.distance == 0]
        ready = [start[e.src] + _separation(dfg, fabric, e.src, e.kind) for e in before]
        time = max(ready, default=0)
        if dfg.by_id[node].op is Opcode.LIVE_OUT:
            time = max([time, *start.values()])
            if len(capture) == ii:
                return {}
            while time % ii in capture:
                time += 1
            capture.add(time % ii)
        else:
            last = fabric.latency(dfg.by_id[node]) - 1
            while time % ii in issue or (time + last) % ii in complete:
                time += 1
                if time > 10 * ii + max(ready, default=0):
                    return {}  # issue slots are left, but none that completes in a free one
            issue.add(time % ii)
            complete.add((time + last) % ii)
        start[node] = time
    return start


def _between(dfg: DFG) -> list[Edge]:
    return [edge for edge in dfg.edges if not dfg.by_id[edge.src].is_source]


def _carries(dfg: DFG, fabric: Fabric, start: dict[int, int], ii: int) -> bool:
    """Dependences hold, those from the iteration before too."""
    if not start:
        return not dfg.placed
    for edge in _between(dfg):
        waits = start[edge.dst] + ii * edge.distance - start[edge.src]
        waits -= _separation(dfg, fabric, edge.src, edge.kind)
        if waits < 0:
            return False
    return True


def _mapping(dfg: DFG, fabric: Fabric, start: dict[int, int], ii: int) -> Mapping:
    """Each word has registers of its own; after II cycles in one it is copied into the next."""
    reads = {
        index: (
            start[edge.src] + fabric.latency(dfg.by_id[edge.src]),
            start[edge.dst] + ii * edge.distance,
        )
        for index, edge in dfg.routed_edges()
    }
    copies: dict[int, int] = {}
    for index, (ready, read) in reads.items():
        node = dfg.edges[index].src
        copies[node] = max(copies.get(node, 0), (read - ready) // ii + 1)
    first = {node: sum(list(copies.values())[:k]) for k, node in enumerate(copies)}
    routes = {}
    for index, (ready, read) in reads.items():
        edge = dfg.edges[index]
        at_once = read == ready and (edge.src + edge.dst) % 2
        times = () if at_once else range(ready, read + 1)
        routes[index] = tuple(
            Step("reg", 0, first[edge.src] + (time - ready) // ii, time) for time in times
        )
    return Mapping(ii, {node: Place(0, time) for node, time in start.items()}, routes)
