"""A lower bound on the II from the least time that words live, whatever the schedule.

A word is somewhere in every cycle from its result to its last read, and each (place, slot) holds
one word: the lives of all words together are at most II times the places. The least sum of lives
over all schedules of an II is a linear program over differences of start times; its dual is a flow
of least cost (Ahuja, Magnanti and Orlin 1993, section 9.4), which is integral.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

import networkx as nx

from vividc.mapper.mapping import Bound
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.dependences import Dependence, dependences, earliest_starts
from vividc.mapper.resources.mrrg import MRRG, build_mrrg

_SHOWN: Final = 6
_MOST_NODES: Final = 1500
"""Operations beyond which the flow takes longer than the bound is worth."""


def pressure_bounds(problem: MapProblem, least: int, beyond: int) -> tuple[Bound, ...]:
    """A bound above `least` (at least the RecMII) if words live too long for each II from there on;
    `beyond`: the II at which to stop.

    Each II is refuted by itself, since more cycles give more room but loop-carried words live
    longer. A word is in (cycles from result to last read) places at least: it needs none in its
    first cycle if it is read from the output register then. And it is read by at most one FU on
    each PE that reads a place in a cycle, so k reads, of which the output register serves the first
    ones, need k / (PEs that read one place) - 1 places. Where output registers are open they are
    places like registers.
    """
    graph = build_mrrg(problem.fabric)
    places = sum(graph.resources[int(r)].capacity for r in dict.fromkeys(graph.occupies.tolist()))
    readers = _readers(problem, graph)
    edges = dependences(problem.dfg, problem.fabric)
    if len(problem.dfg.placed) > _MOST_NODES:
        return ()
    ii, life = least, 0
    while ii < beyond:
        now = _least_life(problem, edges, ii, ii * places, readers)
        if now <= ii * places:
            break
        ii, life = ii + 1, now
    if ii == least:
        return ()
    words = _long_lived(problem, edges, ii)
    names = ", ".join(f"{problem.dfg.by_id[word].op.value} #{word}" for word in words)
    reason = (
        f"words live {life} cycles or more in all at II {ii - 1}, for which links and registers "
        f"have {(ii - 1) * places}; the longest: {names}"
    )
    return (Bound("register pressure", ii, reason, words),)


def least_life(problem: MapProblem, ii: int) -> int:
    """Least sum, over all schedules of `ii`, of the places that words must take; `ii` is at least
    the RecMII.
    """
    readers = _readers(problem, build_mrrg(problem.fabric))
    return _least_life(problem, dependences(problem.dfg, problem.fabric), ii, -1, readers)


def _readers(problem: MapProblem, graph: MRRG) -> int:
    """PEs that read one place, an output register included."""
    seen = Counter(pe for row in problem.fabric.outputs_seen_by for pe in row)
    return max([len(graph.readers[at]) for at in range(graph.locations)] + list(seen.values()))


def _least_life(
    problem: MapProblem, edges: Sequence[Dependence], ii: int, enough: int, readers: int
) -> int:
    """The least sum of lifetimes, or that of some schedule if it is `enough` or less."""
    nodes = [node.id for node in problem.dfg.placed]
    words = list(dict.fromkeys(edge.src for edge in edges if edge.routed))
    latency = {edge.src: edge.latency for edge in edges}
    floor = _reads(problem, edges, words, readers)
    starts = earliest_starts(nodes, edges, ii)
    if starts is None:
        raise ValueError(f"II {ii} is below the RecMII")
    lives = dict(floor)
    for edge in edges:
        if edge.routed:
            lives[edge.src] = max(lives[edge.src], _life(starts, edge, ii))
    early = sum(lives.values())
    if early <= enough:
        return early
    flow = nx.DiGraph()
    flow.add_nodes_from(nodes, demand=0)
    for word in words:
        flow.nodes[word]["demand"] = -1
        flow.add_node(_end(word), demand=1)
    sharpest: dict[tuple[int | _End, int | _End], int] = {}
    for src, dst, weight in _differences(edges, words, latency, floor, ii):
        sharpest[src, dst] = max(weight, sharpest.get((src, dst), weight))
    flow.add_weighted_edges_from((src, dst, -weight) for (src, dst), weight in sharpest.items())
    cost, _ = nx.network_simplex(flow)
    return int(-cost) - sum(latency[word] for word in words)


_End = tuple[str, int]


def _end(word: int) -> _End:
    """The node that stands for the last read of a word."""
    return ("end", word)


def _differences(
    edges: Sequence[Dependence],
    words: Sequence[int],
    latency: dict[int, int],
    floor: dict[int, int],
    ii: int,
) -> Iterator[tuple[int | _End, int | _End, int]]:
    """(a, b, w): b comes w cycles after a at least."""
    for word in words:
        yield word, _end(word), latency[word] + floor[word]
    for edge in edges:
        if edge.src != edge.dst:
            yield edge.src, edge.dst, edge.weight(ii)
        if edge.routed:
            yield edge.dst, _end(edge.src), ii * edge.distance


def _reads(
    problem: MapProblem, edges: Sequence[Dependence], words: Sequence[int], readers: int
) -> dict[int, int]:
    """Least places that the reads of each word take, however short its lifetime."""
    fus = {node.id for node in problem.dfg.operations}
    by_fus: dict[int, set[tuple[int, int]]] = {word: set() for word in words}
    for edge in edges:
        if edge.routed and edge.dst in fus:
            by_fus[edge.src].add((edge.dst, edge.distance))
    return {word: max(-(-len(reads) // readers) - 1, 0) for word, reads in by_fus.items()}


def _life(starts: dict[int, int], edge: Dependence, ii: int) -> int:
    return starts[edge.dst] + ii * edge.distance - starts[edge.src] - edge.latency


def _long_lived(problem: MapProblem, edges: Sequence[Dependence], ii: int) -> tuple[int, ...]:
    """Words that live longest in the earliest schedule."""
    starts = earliest_starts([node.id for node in problem.dfg.placed], edges, ii) or {}
    lives: dict[int, int] = {}
    for edge in edges:
        if edge.routed:
            lives[edge.src] = max(lives.get(edge.src, 0), _life(starts, edge, ii))
    return tuple(sorted(lives, key=lambda word: (-lives[word], word))[:_SHOWN])
