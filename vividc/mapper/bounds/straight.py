"""Lower bounds on the length of a straight region: longest paths with forced hops, shared PEs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

import numpy as np

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Edge, EdgeKind, Node
from vividc.errors import MappingFailed
from vividc.host.once import once_each, once_within
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Bound
from vividc.mapper.problem import Drain, MapProblem
from vividc.mapper.resources.distances import cycles_for


@once_within
def straight_lower_bound(problem: MapProblem) -> Bound:
    """The sharpest lower bound on the length of a straight region, at least 1.

    Longest dependence path with the hops that candidate PEs force; and for operations that share
    PEs, one issue per PE and cycle between the earliest start and the shortest tail (Carlier 1982).
    What waits for a loop that is still under way starts no earlier than that lets it.

    Raises
    ------
    MappingFailed
        Edges of distance 0 form a cycle.
    """
    heights = heights_of(problem)
    heads = _heads(problem, heights)
    bounds = [_path_bound(problem, heights), *_shared_bounds(problem, heights, heads)]
    if problem.drain is not None:
        bounds.append(_drain_bound(problem, problem.drain, heights, heads))
    return max(bounds, key=lambda bound: bound.ii)


def end_after_start(fabric: Fabric, node: Node) -> int:
    """Cycles of the region that `node` needs from its issue on, itself alone."""
    if node.op is Opcode.LIVE_OUT:
        return 1
    latency = max(fabric.latency(node), fabric.occupancy(node))
    if node.control is None:
        return latency
    return max(latency, fabric.latency(node) + fabric.controller.control_latency)


def end_in(problem: MapProblem, node: Node) -> int:
    """As `end_after_start`, with what the loop behind the region needs when it begins."""
    return max(end_after_start(problem.fabric, node), problem.tail(node))


class Heights:
    """Longest paths from each node's issue to the end of the region, forced hops included.

    Attributes
    ----------
    of
        Height of each placed node: no legal schedule has fewer cycles from its issue to its end.
    order
        Placed nodes, producers first.
    """

    def __init__(self, problem: MapProblem) -> None:
        self._problem = problem
        self._hops = _hops(problem.fabric)
        self._candidates = {n.id: problem.candidates(n) for n in problem.dfg.placed}
        self._ahead: dict[tuple[int, tuple[int, ...]], int | list[int]] = {}
        self.order = _topological(problem)
        self.of: dict[int, int] = {}
        self._after: dict[int, list[int]] = {}
        for node in reversed(self.order):
            after = self._after[node] = self._heights(node)
            own = end_in(problem, problem.dfg.by_id[node])
            self.of[node] = min((after[pe] for pe in self._candidates[node]), default=own)

    def after(self, node: int) -> list[int]:
        """Heights of `node` by the PE that it lies on."""
        return self._after[node]

    def separation(self, edge: Edge) -> int:
        """Least start[dst] - start[src], with the producer on its best candidate."""
        separations = self._separations(edge)
        if isinstance(separations, int):
            return separations
        latency = self._problem.fabric.latency(self._problem.dfg.by_id[edge.src])
        return min((separations[pe] for pe in self._candidates[edge.src]), default=latency)

    def _heights(self, node: int) -> list[int]:
        """Heights of `node` on each PE."""
        fabric = self._problem.fabric
        anywhere = end_in(self._problem, self._problem.dfg.by_id[node])
        rows: list[list[int]] = []
        for edge in self._problem.dfg.out_edges[node]:
            below, separations = self.of[edge.dst], self._separations(edge)
            if isinstance(separations, int):
                anywhere = max(anywhere, separations + below)
            else:
                rows.append([ahead + below for ahead in separations])
        everywhere = [anywhere] * len(fabric.pes)
        return list(map(max, everywhere, *rows)) if rows else everywhere

    def _separations(self, edge: Edge) -> int | list[int]:
        """Least start[dst] - start[src], with the producer on each PE if that matters."""
        fabric = self._problem.fabric
        if edge.kind is EdgeKind.ORDER:
            return 1
        latency = fabric.latency(self._problem.dfg.by_id[edge.src])
        if edge.kind is EdgeKind.CONTROL:
            return latency + fabric.controller.control_latency
        targets = self._candidates[edge.dst]
        if (latency, targets) not in self._ahead:
            nearest = (min((row[pe] for pe in targets), default=0) for row in self._hops)
            ahead = [latency + max(0, hops - 1) for hops in nearest]
            self._ahead[latency, targets] = ahead if len(set(ahead)) > 1 else ahead[0]
        return self._ahead[latency, targets]


@once_within
def heights_of(problem: MapProblem) -> Heights:
    """The heights of a region's nodes."""
    return Heights(problem)


def _path_bound(problem: MapProblem, heights: Heights) -> Bound:
    if not heights.of:
        return Bound("critical path", 1, "the region is empty")
    node = max(heights.order, key=lambda item: heights.of[item])
    path = [node]
    while True:
        tight = [
            edge.dst
            for edge in problem.dfg.out_edges[path[-1]]
            if heights.separation(edge) + heights.of[edge.dst] >= heights.of[path[-1]]
        ]
        if not tight:
            break
        path.append(tight[0])
    text = " -> ".join(str(item) for item in path)
    return Bound("critical path", max(1, heights.of[node]), f"nodes {text}", tuple(path))


def _drain_bound(
    problem: MapProblem, drain: Drain, heights: Heights, heads: dict[int, int]
) -> Bound:
    """What waits for a loop that is still under way, and what comes after it."""
    nodes: tuple[int, ...] = ()
    length = drain.cycles
    for node in heights.order:
        if heads[node] + heights.of[node] > length:
            length, nodes = heads[node] + heights.of[node], (node,)
    return Bound("drain", length, f"the loop before it takes {drain.cycles} of its cycles", nodes)


def _heads(problem: MapProblem, heights: Heights) -> dict[int, int]:
    heads = {node: problem.releases.get(node, 0) for node in heights.order}
    for node in heights.order:
        for edge in problem.dfg.out_edges[node]:
            heads[edge.dst] = max(heads[edge.dst], heads[node] + heights.separation(edge))
    return heads


def _shared_bounds(problem: MapProblem, heights: Heights, heads: dict[int, int]) -> Iterator[Bound]:
    operations: dict[frozenset[int], list[int]] = defaultdict(list)
    live_outs: dict[frozenset[int], list[int]] = defaultdict(list)
    for node in problem.dfg.placed:
        groups = live_outs if node.op is Opcode.LIVE_OUT else operations
        groups[frozenset(problem.candidates(node))].append(node.id)
    for groups, what in ((operations, "operations"), (live_outs, "live-outs")):
        for pes in _unions(groups):
            users = [n for group, nodes in groups.items() if group <= pes for n in nodes]
            length = _shared_length(users, len(pes), heads, heights.of)
            reason = f"{len(users)} {what} share {len(pes)} PEs"
            yield Bound("shared PEs", length, reason, tuple(sorted(users)))
    accesses = [node.id for node in problem.dfg.placed if node.is_memory]
    if accesses:
        banks = problem.fabric.scratchpad.banks
        length = _shared_length(accesses, banks, heads, heights.of)
        yield Bound("banks", length, f"{banks} accesses a cycle", tuple(accesses))
    controls = [node.id for node in problem.dfg.placed if node.control is not None]
    if controls:
        length = _shared_length(controls, 1, _results(problem, controls, heads), _ends(problem))
        yield Bound("control port", length, "one control result a cycle", tuple(controls))


def _unions(groups: Iterable[frozenset[int]]) -> list[frozenset[int]]:
    """The groups with candidates, and the union of all."""
    known = [group for group in groups if group]
    return list(dict.fromkeys([*known, frozenset().union(*known)])) if known else []


def _shared_length(users: list[int], pes: int, heads: dict[int, int], tails: dict[int, int]) -> int:
    """Max over sets {head >= h, tail >= t} of h + t + cycles to issue all but the last of them."""
    length = 1
    latest_first = sorted(users, key=heads.__getitem__, reverse=True)
    head = np.array([heads[node] for node in latest_first])
    tail = np.array([tails[node] for node in latest_first])
    for least_tail in sorted(set(tail.tolist())):
        inside = head[tail >= least_tail]
        issued = np.arange(len(inside)) // pes
        length = max(length, int((inside + issued).max()) + least_tail)
    return length


def _results(problem: MapProblem, nodes: list[int], heads: dict[int, int]) -> dict[int, int]:
    return {n: heads[n] + problem.fabric.latency(problem.dfg.by_id[n]) for n in nodes}


def _ends(problem: MapProblem) -> dict[int, int]:
    return dict.fromkeys(
        (node.id for node in problem.dfg.placed), problem.fabric.controller.control_latency
    )


@once_each
def _hops(fabric: Fabric) -> list[list[int]]:
    """Cycles between PEs, links passed one a cycle or as many as the fabric permits; as many as
    there are PEs where no links lead.
    """
    count = len(fabric.pes)
    hops = [[0 if a == b else count for b in range(count)] for a in range(count)]
    for start in range(count):
        frontier = [start]
        while frontier:
            reached = dict.fromkeys(k.dst for pe in frontier for k in fabric.links_from[pe])
            distance = hops[start][frontier[0]] + 1
            frontier = [pe for pe in reached if hops[start][pe] > distance]
            for pe in frontier:
                hops[start][pe] = distance
    a_cycle = fabric.routing.hops
    return [[h if h == count else cycles_for(h, a_cycle) for h in row] for row in hops]


def _topological(problem: MapProblem) -> tuple[int, ...]:
    waits = {node.id: 0 for node in problem.dfg.placed}
    for edge in problem.dfg.edges:
        if edge.src in waits and edge.distance == 0:
            waits[edge.dst] += 1
    order = [node for node, count in waits.items() if not count]
    for node in order:  # grows while it is walked
        for edge in problem.dfg.out_edges[node]:
            if edge.distance:
                continue
            waits[edge.dst] -= 1
            if not waits[edge.dst]:
                order.append(edge.dst)
    if len(order) < len(waits):
        raise MappingFailed(f"{problem.dfg.name}: edges of distance 0 form a cycle")
    return tuple(order)
