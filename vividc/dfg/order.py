"""An evaluation order of one iteration: topological over the edges of distance 0."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

from vividc.dfg.ir import DFG, Control
from vividc.errors import DFGError, printable
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode


def evaluation_order(dfg: DFG) -> tuple[int, ...]:
    """Node ids such that every edge of distance 0, ORDER and CONTROL included, points forward.

    The exit node also precedes every `unless_exit` effect. Ties go to the node created first, so
    the order is deterministic.

    Raises
    ------
    DFGError
        The edges of distance 0 form a cycle.
    """
    order = partial_order(dfg)
    if len(order) < len(dfg.nodes):
        cycle = cyclic_nodes(dfg)
        raise DFGError(
            f"nodes {', '.join(map(str, cycle))} form a cycle of distance 0",
            loc=printable(dfg.name),
        )
    return order


def cyclic_nodes(dfg: DFG) -> tuple[int, ...]:
    """Nodes on cycles of distance 0 or behind one; empty if there is no such cycle."""
    ordered = set(partial_order(dfg))
    return tuple(node.id for node in dfg.nodes if node.id not in ordered)


def zero_cycle(dfg: DFG) -> tuple[int, ...]:
    """Node ids along one cycle of distance 0, each feeding the next; empty if there is none."""
    stuck = set(cyclic_nodes(dfg))
    feeder = {dst: src for src, dst in _precedences(dfg) if src in stuck and dst in stuck}
    if not stuck:
        return ()
    # Every node that cannot be ordered waits for another such node: backwards lies a cycle.
    node = next(node.id for node in dfg.nodes if node.id in stuck)
    for _ in range(len(stuck)):
        node = feeder[node]
    cycle = [node]
    while feeder[cycle[-1]] != node:
        cycle.append(feeder[cycle[-1]])
    return tuple(reversed(cycle))


@once_each
def partial_order(dfg: DFG) -> tuple[int, ...]:
    """As `evaluation_order`, without the nodes on cycles of distance 0 and those behind them."""
    position = {node.id: index for index, node in enumerate(dfg.nodes)}
    waits = {node.id: 0 for node in dfg.nodes}
    followers: dict[int, list[int]] = {node.id: [] for node in dfg.nodes}
    for src, dst in _precedences(dfg):
        if src in waits and dst in waits:  # a dangling edge is `check`'s to report
            waits[dst] += 1
            followers[src].append(dst)
    ready = [position[node_id] for node_id, count in waits.items() if count == 0]
    heapq.heapify(ready)
    order: list[int] = []
    while ready:
        node_id = dfg.nodes[heapq.heappop(ready)].id
        order.append(node_id)
        for follower in followers[node_id]:
            waits[follower] -= 1
            if waits[follower] == 0:
                heapq.heappush(ready, position[follower])
    return tuple(order)


def _precedences(dfg: DFG) -> Iterator[tuple[int, int]]:
    for edge in dfg.edges:
        if edge.distance == 0:
            yield edge.src, edge.dst
    exits = [node.id for node in dfg.nodes if node.control is Control.EXIT]
    for exit_id in exits[:1]:
        for node in dfg.nodes:
            if node.unless_exit and node.op is not Opcode.LOAD:
                yield exit_id, node.id
