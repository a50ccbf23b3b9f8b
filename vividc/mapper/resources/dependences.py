"""Dependences of a DFG on a fabric as integers, and the longest paths that bounds and time windows
rest on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, EdgeKind


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
    found = []
    for index, edge in enumerate(dfg.edges):
        source = dfg.by_id[edge.src]
        if source.is_source:
            continue
        latency = fabric.latency(source)
        separation = {
            EdgeKind.DATA: latency,
            EdgeKind.ORDER: 1,
            EdgeKind.CONTROL: latency + fabric.controller.control_latency,
        }[edge.kind]
        found.append(
            Dependence(edge.src, edge.dst, edge.distance, separation, edge.is_data, latency, index)
        )
    return tuple(found)


def earliest_starts(
    nodes: Iterable[int], edges: Iterable[Dependence], ii: int
) -> dict[int, int] | None:
    """Longest path from the beginning to each node (Bellman-Ford); None if a cycle is positive, so
    II too small.
    """
    start = dict.fromkeys(nodes, 0)
    edges = tuple(edges)
    for _ in range(len(start) + 1):
        if not _relax(start, edges, ii):
            return start
    return None


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
    edges = tuple(edges)
    into: dict[int, Dependence] = {}
    moved: int | None = None
    for _ in range(len(start) + 1):
        moved = None
        for edge in edges:
            reached = start[edge.src] + edge.weight(ii)
            if reached > start[edge.dst]:
                start[edge.dst] = reached
                into[edge.dst] = edge
                moved = edge.dst
        if moved is None:
            return ()
    return _walk_back(into, moved, len(start)) if moved is not None else ()


def _walk_back(into: Mapping[int, Dependence], node: int, steps: int) -> tuple[Dependence, ...]:
    for _ in range(steps):  # after so many steps back the walk is inside the cycle
        node = into[node].src
    cycle = [into[node]]
    while cycle[-1].src != node:
        cycle.append(into[cycle[-1].src])
    return tuple(reversed(cycle))


def _relax(start: dict[int, int], edges: Iterable[Dependence], ii: int) -> bool:
    changed = False
    for edge in edges:
        reached = start[edge.src] + edge.weight(ii)
        if reached > start[edge.dst]:
            start[edge.dst] = reached
            changed = True
    return changed
