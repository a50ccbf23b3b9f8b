"""The least total lifetime of words, to check a bound: a linear program over start times.

The least sum of lives is the cost of a flow (Ahuja, Magnanti and Orlin 1993, section 9.4) in which
every word sends one unit from its operation to its end. It shares no line with `pressure`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import networkx as nx

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Edge, EdgeKind
from vividc.mapper.mapping import Subject

_Event = tuple[int, bool]
"""(node, False): it issues; (node, True): its word is read for the last time."""
_Least = dict[tuple[_Event, _Event], int]
"""(a, b): the least cycles from a to b."""

_START: Final = False
_END: Final = True


def separation(edge: Edge, subject: Subject) -> int:
    """Least cycles between the starts of an edge's ends, within one iteration."""
    latency = subject.fabric.latency(subject.dfg.by_id[edge.src])
    if edge.kind is EdgeKind.CONTROL:
        return latency + subject.fabric.controller.control_latency
    return latency if edge.kind is EdgeKind.DATA else 1


def places_for_words(fabric: Fabric) -> int:
    """Words that can be in flight at once: links, registers with ports, and output registers
    that words can stay in or pass.
    """
    routing = fabric.routing
    links = len(fabric.links) if routing.hops else 0
    outputs = len(fabric.pes) if routing.holds or routing.shared or routing.moves else 0
    files = [pe.registers for pe in fabric.pes if pe.read_ports and pe.write_ports]
    return links + outputs + sum(files)


def least_sum_of_lives(subject: Subject, ii: int) -> int | None:
    """The least sum over all words of the cycles from result to last read, over all schedules of
    `ii`, counting for each word the places that its reads take at least; None: no schedule.
    """
    latency = {e.src: subject.fabric.latency(subject.dfg.by_id[e.src]) for e in _routed(subject)}
    least: _Least = {}
    for a, b, cycles in _waits(subject, latency, ii):
        if a == b and cycles > 0:
            return None
        if a != b:
            least[a, b] = max(cycles, least.get((a, b), cycles))
    flow = nx.DiGraph()
    for node in subject.dfg.placed:
        flow.add_node((node.id, _START), demand=-1 if node.id in latency else 0)
    for word in latency:
        flow.add_node((word, _END), demand=1)
    flow.add_weighted_edges_from((a, b, -cycles) for (a, b), cycles in least.items())
    try:
        cost, _ = nx.network_simplex(flow)
    except nx.NetworkXUnbounded:
        return None
    return int(-cost) - sum(latency.values())


def _routed(subject: Subject) -> list[Edge]:
    return [edge for _, edge in subject.dfg.routed_edges()]


def _waits(
    subject: Subject, latency: dict[int, int], ii: int
) -> Iterator[tuple[_Event, _Event, int]]:
    for edge in subject.dfg.edges:
        if not subject.dfg.by_id[edge.src].is_source:
            cycles = separation(edge, subject) - ii * edge.distance
            yield (edge.src, _START), (edge.dst, _START), cycles
    for edge in _routed(subject):
        yield (edge.dst, _START), (edge.src, _END), ii * edge.distance
    for word, cycles in latency.items():
        yield (word, _START), (word, _END), cycles + _places_for_reads(subject, word)


def _places_for_reads(subject: Subject, word: int) -> int:
    """In a cycle a place serves one FU on each PE that reads it; the output register, in the first
    cycle, serves as many and takes no place.
    """
    fabric = subject.fabric
    beside: dict[int, set[int]] = {pe.id: {pe.id} for pe in fabric.pes}
    for link in fabric.links if fabric.routing.shared else ():
        beside[link.src].add(link.dst)
    served = max(len(pes) for pes in beside.values())
    reads = {
        (edge.dst, edge.distance)
        for edge in subject.dfg.out_edges[word]
        if edge.is_data and subject.dfg.by_id[edge.dst].uses_fu
    }
    return max(0, -(-len(reads) // served) - 1)
