"""Removal of nodes without effect on memory, a variable or the controller."""

from __future__ import annotations

from vividc.dfg.ir import DFG, Edge, EdgeKind
from vividc.dfg.passes.rewrite import Rewrite
from vividc.machine.opcodes import ORDER, Opcode

_EFFECTS = frozenset({Opcode.STORE, Opcode.LIVE_OUT})


def remove_dead_nodes(dfg: DFG) -> DFG:
    """Drop every node from which no effect and no control node can be reached along data edges.

    A foreign graph is returned as it is: what its operations do is unknown. Where a dead load
    separated two other accesses by ORDER edges, they stay in order.
    """
    if any(node.op is Opcode.GENERIC for node in dfg.nodes):
        return dfg
    live = _live(dfg)
    rewrite = Rewrite(dfg)
    for node in dfg.nodes:
        if node.id not in live:
            _bridge_order(rewrite, node.id)
            rewrite.remove_node(node.id)
    return rewrite.result()


def _live(dfg: DFG) -> set[int]:
    pending = [node.id for node in dfg.nodes if node.op in _EFFECTS or node.control is not None]
    live = set(pending)
    while pending:
        for edge in dfg.in_edges[pending.pop()]:
            if not edge.is_data:
                continue
            for source in (edge.src, edge.init):
                if source is not None and source not in live:
                    live.add(source)
                    pending.append(source)
    return live


def _bridge_order(rewrite: Rewrite, node_id: int) -> None:
    before = [edge for edge in rewrite.in_edges(node_id) if edge.kind is EdgeKind.ORDER]
    after = [edge for edge in rewrite.out_edges(node_id) if edge.kind is EdgeKind.ORDER]
    for first in before:
        for second in after:
            distance, assumed = first.distance + second.distance, first.assumed or second.assumed
            _order(rewrite, first.src, second.dst, distance, assumed=assumed)


def _order(rewrite: Rewrite, src: int, dst: int, distance: int, *, assumed: bool) -> None:
    loads = [rewrite.nodes[end].op is Opcode.LOAD for end in (src, dst)]
    known = any(
        edge.dst == dst and edge.kind is EdgeKind.ORDER and edge.distance <= distance
        for edge in rewrite.out_edges(src)
    )
    if not all(loads) and not known:
        edge = Edge(src, dst, ORDER, distance, kind=EdgeKind.ORDER, assumed=assumed)
        rewrite.add_edge(edge)
