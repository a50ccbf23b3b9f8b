"""Bounds from the PEs that a word can reach at all: for fabrics with islands or without links."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Node
from vividc.errors import printable
from vividc.mapper.mapping import Bound
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.distances import FAR, hop_distances

Reach = tuple[frozenset[int], ...]
"""For each PE, the PEs that can ever read a word made there."""


def reachable(fabric: Fabric) -> Reach:
    """A word goes as far as links lead; where links carry none and FUs move none, to the readers of
    its PE's output register.
    """
    routing = fabric.routing
    most = FAR - 1
    if not routing.hops and not (routing.moves and routing.shared):
        most = int(routing.shared)
    return tuple(
        frozenset(pe for pe, hops in enumerate(row) if hops <= most)
        for row in hop_distances(fabric)
    )


def operand_bounds(
    problem: MapProblem, candidates: dict[int, frozenset[int]], no_ii: int
) -> tuple[Bound, ...]:
    """A bound for each node that reads more words at once than can arrive at any of its PEs: one
    over each link, one from each read port, and one from each output register.
    """
    most = [_words_at_once(problem.fabric, pe) for pe in range(len(problem.fabric.pes))]
    words: dict[int, set[tuple[int, int]]] = {node: set() for node in candidates}
    for _, edge in problem.dfg.routed_edges():
        words[edge.dst].add((edge.src, edge.distance))
    bounds = []
    for node, read in words.items():
        least = max((most[pe] for pe in candidates[node]), default=0)
        if len(read) > least:
            reason = f"{_name(problem.dfg.by_id[node])} reads {len(read)} words at once: {least} "
            reason += "come to a PE over its links, from its registers and as results"
            bounds.append(Bound("operands", no_ii, reason, (node,)))
    return tuple(bounds)


def _words_at_once(fabric: Fabric, pe: int) -> int:
    links = len(fabric.links_to[pe]) if fabric.routing.hops else 0
    file = fabric.pes[pe]
    return links + min(file.registers, file.read_ports) + len(fabric.outputs_seen_by[pe])


def unreachable_bounds(
    problem: MapProblem, candidates: dict[int, frozenset[int]], no_ii: int
) -> tuple[Bound, ...]:
    """A bound for the first edge whose ends can lie nowhere: places without a partner are taken
    away until none is left over (arc consistency: Mackworth 1977).
    """
    reach = reachable(problem.fabric)
    if all(len(pes) == len(reach) for pes in reach):
        return ()
    left = dict(candidates)
    edges = [edge for _, edge in problem.dfg.routed_edges()]
    changed = True
    while changed:
        changed = False
        for edge in edges:
            before = left[edge.src], left[edge.dst]
            left[edge.src] = frozenset(pe for pe in before[0] if reach[pe] & before[1])
            reached: frozenset[int] = frozenset().union(*(reach[pe] for pe in left[edge.src]))
            left[edge.dst] = before[1] & reached
            if not left[edge.dst]:
                return (_nowhere(problem.dfg, edge.src, edge.dst, no_ii),)
            changed = changed or before != (left[edge.src], left[edge.dst])
    return ()


def _nowhere(dfg: DFG, src: int, dst: int, no_ii: int) -> Bound:
    ends = " to ".join(_name(dfg.by_id[node]) for node in (src, dst))
    reason = f"no word gets from {ends}: no PE that can run the first leads to one for the second"
    return Bound("reach", no_ii, reason, (src, dst))


def island_bounds(problem: MapProblem, candidates: dict[int, frozenset[int]]) -> tuple[Bound, ...]:
    """Operations connected by words share one island of connected PEs and its issue slots; the
    largest such group binds.
    """
    islands = _groups(
        len(problem.fabric.pes),
        ((pe, to) for pe, pes in enumerate(reachable(problem.fabric)) for to in sorted(pes)),
    )
    if len(islands) < 2:  # noqa: PLR2004 - one island is the whole array
        return ()
    position = {node.id: number for number, node in enumerate(problem.dfg.placed)}
    pairs = ((position[e.src], position[e.dst]) for _, e in problem.dfg.routed_edges())
    bounds = []
    for group in _groups(len(position), pairs):
        nodes = [problem.dfg.placed[number] for number in group]
        bound = _group_bound(problem, nodes, islands, candidates)
        if bound is not None:
            bounds.append(bound)
    return tuple(sorted(bounds, key=lambda bound: -bound.ii)[:1])


def _group_bound(
    problem: MapProblem,
    nodes: Sequence[Node],
    islands: Sequence[Sequence[int]],
    candidates: dict[int, frozenset[int]],
) -> Bound | None:
    cycles = sum(problem.fabric.occupancy(node) for node in nodes if node.uses_fu)
    sizes = [
        len(island)
        for island in islands
        if all(candidates[node.id] & frozenset(island) for node in nodes)
    ]
    if not sizes or not cycles:
        return None
    reason = f"{len(nodes)} connected nodes on one island of at most {max(sizes)} PEs"
    return Bound("island", -(-cycles // max(sizes)), reason, tuple(node.id for node in nodes))


def _groups(count: int, pairs: Iterator[tuple[int, int]]) -> tuple[tuple[int, ...], ...]:
    """Connected groups of 0 .. count - 1, each ascending."""
    root = list(range(count))

    def find(item: int) -> int:
        while root[item] != item:
            root[item] = root[root[item]]
            item = root[item]
        return item

    for one, other in pairs:
        root[find(other)] = find(one)
    groups: dict[int, list[int]] = {}
    for item in range(count):
        groups.setdefault(find(item), []).append(item)
    return tuple(tuple(group) for group in groups.values())


def _name(node: Node) -> str:
    label = printable(f"{node.op.value} {node.name}".strip())
    return f"{label} #{node.id}" if node.loc is None else f"{label} #{node.id} ({node.loc})"
