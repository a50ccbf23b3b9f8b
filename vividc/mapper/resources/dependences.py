"""Dependences of a DFG on a fabric as integers, and the longest paths that bounds and time windows
rest on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, EdgeKind
from vividc.host.once import made_soon, once_each
from vividc.machine.opcodes import LatencyClass


@made_soon
@dataclass(frozen=True, slots=True)
class Dependence:
    """start[dst] + II * distance >= start[src] + separation, between placed nodes.

    `routed`: the edge carries a word, so it needs a route as well. `latency` is the producer's,
    `index` the edge's in `dfg.edges`.
    """

    src: int
    dst: int
    distance: int
    separation: int
    routed: bool
    latency: int
    index: int

    def weight(self, ii: int) -> int:
        """Least start[dst] - start[src] at this II."""
        return self.separation - ii * self.distance


def dependences(dfg: DFG, fabric: Fabric) -> tuple[Dependence, ...]:
    """Every edge between placed nodes, in edge order."""
    return _dependences(dfg, tuple(fabric.latencies.items()), fabric.controller.control_latency)


@once_each
def _dependences(
    dfg: DFG, latencies: tuple[tuple[LatencyClass, int], ...], control_latency: int
) -> tuple[Dependence, ...]:
    cycles = dict(latencies)
    latency_of = {node.id: cycles[node.latency_class] for node in dfg.placed}
    deps = []
    for index, edge in enumerate(dfg.edges):
        latency = latency_of.get(edge.src)
        if latency is None:
            continue
        separation = 1 if edge.kind is EdgeKind.ORDER else latency
        if edge.kind is EdgeKind.CONTROL:
            separation += control_latency
        deps.append(
            Dependence(edge.src, edge.dst, edge.distance, separation, edge.is_data, latency, index)
        )
    return tuple(deps)


def earliest_starts(
    nodes: Iterable[int], edges: Iterable[Dependence], ii: int
) -> dict[int, int] | None:
    """Longest path from the beginning to each node (Bellman-Ford); None if a cycle is positive, so
    II too small.
    """
    start, cycle = _longest_paths(nodes, _rows(edges), ii)
    return None if cycle else start


def least_ii(nodes: Iterable[int], edges: Iterable[Dependence]) -> int | None:
    """The least II at which no cycle is positive, so the maximum cycle ratio, rounded up; None if
    a positive cycle has distance 0.

    Binary search (Lawler 1976), where an II that is too small has a positive cycle, whose ratio is
    the next lower bound.
    """
    nodes, rows = tuple(nodes), _rows(edges)
    low, ii = 0, 0
    high: int | None = None
    while high is None or low < high:
        _, cycle = _longest_paths(nodes, rows, ii)
        if cycle:
            distance = sum(edge.distance for edge in cycle)
            if not distance:
                return None
            low = -(-sum(edge.separation for edge in cycle) // distance)
        else:
            high = ii
        ii = max(low, 2 * ii) if high is None else (low + high) // 2
    return low


def longest_tails(nodes: Iterable[int], edges: Iterable[Dependence], ii: int) -> dict[int, int]:
    """Longest path from each node to an end. The II must not be below the RecMII."""
    reverse = tuple(replace(edge, src=edge.dst, dst=edge.src) for edge in edges)
    tails = earliest_starts(nodes, reverse, ii)
    if tails is None:
        raise ValueError(f"II {ii} is below the RecMII")
    return tails


def positive_cycle(
    nodes: Iterable[int], edges: Iterable[Dependence], ii: int
) -> tuple[Dependence, ...]:
    """Edges of a cycle whose separations exceed II times its distance, or () if there is none."""
    start = dict.fromkeys(nodes, 0)
    rows = _weighed(_rows(edges), ii)
    into: dict[int, Dependence] = {}
    moved: int | None = None
    for _ in range(len(start) + 1):
        moved = _relax(start, rows, into)
        if moved is None:
            return ()
    return _walk_back(into, moved, len(start)) if moved is not None else ()


_Row = tuple[int, int, int, int, Dependence]
"""Source, destination, separation and distance of a dependence, and itself."""

_Weighed = tuple[int, int, int, Dependence]
"""The same at an II: source, destination, and cycles between their starts."""


def _rows(edges: Iterable[Dependence]) -> list[_Row]:
    return [(edge.src, edge.dst, edge.separation, edge.distance, edge) for edge in edges]


def _longest_paths(
    nodes: Iterable[int], rows: list[_Row], ii: int
) -> tuple[dict[int, int], tuple[Dependence, ...]]:
    """Longest path from the beginning to each node, or some positive cycle.

    A cycle of edges that each moved their destination last is positive (Cherkassky and Goldberg
    1999): it shows long before as many rounds as nodes have passed.
    """
    start = dict.fromkeys(nodes, 0)
    into: dict[int, Dependence] = {}
    weighed = _weighed(rows, ii)
    for number in range(1, len(start) + 2):
        moved = _relax(start, weighed, into)
        if moved is None:
            return start, ()
        if number & (number - 1) == 0 and (cycle := _cycle_of(into)):
            return start, cycle
    return start, _walk_back(into, moved, len(start)) if moved is not None else ()


def _weighed(rows: list[_Row], ii: int) -> list[_Weighed]:
    return [(src, dst, ahead - ii * distance, edge) for src, dst, ahead, distance, edge in rows]


def _relax(start: dict[int, int], rows: list[_Weighed], into: dict[int, Dependence]) -> int | None:
    """Move nodes past those they depend on, once for each edge; return the last that moved."""
    moved = None
    for src, dst, ahead, edge in rows:
        reached = start[src] + ahead
        if reached > start[dst]:
            start[dst] = reached
            into[dst] = edge
            moved = dst
    return moved


def _cycle_of(into: Mapping[int, Dependence]) -> tuple[Dependence, ...]:
    """A cycle among edges of which each node has at most one that leads to it; () if none."""
    walk_of: dict[int, int] = {}
    for walk in into:
        node = walk
        while node in into and node not in walk_of:
            walk_of[node] = walk
            node = into[node].src
        if walk_of.get(node) == walk and node in into:
            return _walk_back(into, node, 0)
    return ()


def _walk_back(into: Mapping[int, Dependence], node: int, steps: int) -> tuple[Dependence, ...]:
    for _ in range(steps):  # after so many steps back the walk is inside the cycle
        node = into[node].src
    cycle = [into[node]]
    while cycle[-1].src != node:
        cycle.append(into[cycle[-1].src])
    return tuple(reversed(cycle))
