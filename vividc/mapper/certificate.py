"""Checks a result's certificate without a solver: its mapping, its bounds, and what they prove.

Each check derives the bound anew from the graph and the fabric, given only the nodes and edges that
are said to bind; it shares no line with `bounds`. What a solver refuted is not proved again: it is
listed as taken on trust.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, Literal

from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Bound, MapResult, Subject
from vividc.mapper.verify import violations

Verdict = Literal["confirmed", "trusted", "wrong"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One statement of a result, and what became of checking it."""

    verdict: Verdict
    what: str

    def __str__(self) -> str:
        return f"{self.verdict}: {self.what}"


def check_certificate(result: MapResult, subject: Subject) -> tuple[Finding, ...]:
    """Check everything that `result` says about mapping a graph onto a fabric.

    Returns
    -------
    tuple of Finding
        "wrong" findings contradict the result; "trusted" ones rest on the word of a solver, or are
        bounds of a kind that this module does not know.
    """
    bounds = [_check_bound(bound, subject) for bound in result.bounds]
    confirmed = [
        bound.ii
        for bound, finding in zip(result.bounds, bounds, strict=True)
        if finding.verdict == "confirmed"
    ]
    proved = max([1, *confirmed])
    return (
        *_check_mapping(result, subject),
        *bounds,
        *_check_lower_bound(result, proved),
        *_check_status(result, subject),
    )


def cycle_edges(bound: Bound, subject: Subject) -> tuple[int, ...]:
    """Indices of the edges along the recurrence that a bound names by its nodes.

    Between two nodes the edge is taken that binds most at the II below the bound. Empty if the
    nodes form no cycle of the graph.
    """
    found = []
    for src, dst in zip(bound.nodes, [*bound.nodes[1:], *bound.nodes[:1]], strict=True):
        parallel = [i for i, e in enumerate(subject.dfg.edges) if (e.src, e.dst) == (src, dst)]
        if not parallel:
            return ()
        found.append(max(parallel, key=lambda i: _weight(i, bound.ii - 1, subject)))
    return tuple(found)


def _weight(edge: int, ii: int, subject: Subject) -> int:
    found = subject.dfg.edges[edge]
    return _separation(found, subject) - ii * found.distance


def _separation(edge: Edge, subject: Subject) -> int:
    """Least cycles between the starts of an edge's ends, within one iteration."""
    latency = subject.fabric.latency(subject.dfg.by_id[edge.src])
    if edge.kind is EdgeKind.CONTROL:
        return latency + subject.fabric.controller.control_latency
    return latency if edge.kind is EdgeKind.DATA else 1


def _check_mapping(result: MapResult, subject: Subject) -> Iterator[Finding]:
    mapping = result.mapping
    if mapping is None:
        if result.ii is not None:
            yield Finding("wrong", f"II {result.ii} is claimed without a mapping")
        return
    found = violations(subject.dfg, subject.fabric, mapping)
    yield from (Finding("wrong", f"the mapping breaks a rule: {broken}") for broken in found)
    if not found:
        yield Finding("confirmed", f"the mapping is legal at II {mapping.ii}")
    if mapping.ii != result.ii:
        yield Finding("wrong", f"the mapping has II {mapping.ii}, the result says {result.ii}")


def _check_bound(bound: Bound, subject: Subject) -> Finding:
    text = f"{bound.name} {bound.ii}: {bound.reason}"
    unknown = [node for node in bound.nodes if node not in subject.dfg.by_id]
    if unknown:
        return Finding("wrong", f"{text} (the graph has no node {unknown[0]})")
    check = _CHECKS.get(bound.name)
    if check is None:
        return Finding("trusted", f"{text} (no check is known for this kind of bound)")
    return Finding("confirmed" if check(bound, subject) else "wrong", text)


def _never(subject: Subject) -> int:
    """The II that stands for "no II works"."""
    return subject.fabric.controller.contexts + 1


def _recurrence(bound: Bound, subject: Subject) -> bool:
    edges = [subject.dfg.edges[index] for index in cycle_edges(bound, subject)]
    latency = sum(_separation(edge, subject) for edge in edges)
    distance = sum(edge.distance for edge in edges)
    if distance == 0:
        return bool(edges) and latency > 0 and bound.ii == _never(subject)
    return latency > (bound.ii - 1) * distance


def _users(bound: Bound, subject: Subject) -> list[Node]:
    return [subject.dfg.by_id[node] for node in dict.fromkeys(bound.nodes)]


def _issue(bound: Bound, subject: Subject) -> bool:
    users = [node for node in _users(bound, subject) if node.uses_fu]
    cycles = sum(subject.fabric.occupancy(node) for node in users)
    return cycles > (bound.ii - 1) * len(_pes_of(users, subject))


def _occupancy(bound: Bound, subject: Subject) -> bool:
    """An operation follows itself no sooner than it leaves its FU."""
    kept = [subject.fabric.occupancy(node) for node in _users(bound, subject) if node.uses_fu]
    return max(kept, default=1) >= bound.ii


def _live_outs(bound: Bound, subject: Subject) -> bool:
    users = [node for node in _users(bound, subject) if node.op is Opcode.LIVE_OUT]
    return len(users) > (bound.ii - 1) * len(_pes_of(users, subject))


def _control(bound: Bound, subject: Subject) -> bool:
    return sum(node.control is not None for node in _users(bound, subject)) >= bound.ii


def _banks(bound: Bound, subject: Subject) -> bool:
    accesses = sum(node.is_memory for node in _users(bound, subject))
    return accesses > (bound.ii - 1) * subject.fabric.scratchpad.banks


def _placement(bound: Bound, subject: Subject) -> bool:
    impossible = any(not _pes_of([node], subject) for node in _users(bound, subject))
    return impossible and bound.ii == _never(subject)


def _stages(bound: Bound, subject: Subject) -> bool:
    """At the II below, the longest path leaves the stages, or there is no longest path."""
    ii = bound.ii - 1
    start = {node.id: 0 for node in subject.dfg.placed}
    edges = [edge for edge in subject.dfg.edges if edge.src in start]
    for _ in range(len(start) + 1):
        before = dict(start)
        for edge in edges:
            reached = start[edge.src] + _separation(edge, subject) - ii * edge.distance
            start[edge.dst] = max(start[edge.dst], reached)
        if start == before:
            return max(start.values(), default=0) >= subject.fabric.controller.max_stages * ii
    return True


def _lifetime(bound: Bound, subject: Subject) -> bool:
    """More instances of one word are alive than there are places for words."""
    fabric = subject.fabric
    links = len(fabric.links) if fabric.routing.hops else 0
    places = links + sum(pe.registers + 1 for pe in fabric.pes)
    ends = [edge for edge in subject.dfg.edges if (edge.src, edge.dst) == bound.nodes]
    alive = [
        edge.distance - fabric.controller.max_stages - _separation(edge, subject)
        for edge in ends
        if edge.is_data
    ]
    return max(alive, default=0) > places and bound.ii == _never(subject)


def _entry(bound: Bound, subject: Subject) -> bool:
    """A live-out's operand, or its word before the first iteration, is the entry it writes."""
    for node in _users(bound, subject):
        for edge in subject.dfg.in_edges[node.id]:
            for origin in (edge.src, edge.init):
                source = None if origin is None else subject.dfg.by_id[origin]
                reads = source is not None and source.op is Opcode.LIVE_IN and edge.is_data
                if reads and source is not None and source.name == node.name:
                    return node.op is Opcode.LIVE_OUT and bound.ii == _never(subject)
    return False


def _operands(bound: Bound, subject: Subject) -> bool:
    """Of one cycle: a word from each link, each read port, each output register within reach."""
    users = _users(bound, subject)
    if len(users) != 1:
        return False
    node = users[0]
    words = {
        (edge.src, edge.distance)
        for edge in subject.dfg.in_edges[node.id]
        if edge.is_data and not subject.dfg.by_id[edge.src].is_source
    }
    fabric, most = subject.fabric, 0
    for pe in _pes_of([node], subject):
        into = sum(link.dst == pe for link in fabric.links)
        file = fabric.pes[pe]
        here = 1 + min(file.registers, file.read_ports) + into * bool(fabric.routing.hops)
        most = max(most, here + into * fabric.routing.shared)
    return len(words) > most and bound.ii == _never(subject)


_CHECKS: Final[dict[str, Callable[[Bound, Subject], bool]]] = {
    "RecMII": _recurrence,
    "ResMII": _issue,
    "FU occupancy": _occupancy,
    "live-out writes": _live_outs,
    "control port": _control,
    "banks": _banks,
    "placement": _placement,
    "stages": _stages,
    "lifetime": _lifetime,
    "live-out entry": _entry,
    "operands": _operands,
}


def _pes_of(users: list[Node], subject: Subject) -> set[int]:
    """PEs that can take any of the users."""
    dfg, fabric = subject.dfg, subject.fabric
    return {
        pe.id
        for node in users
        for pe in fabric.pes
        if fabric.supports(pe.id, node) and _constants(dfg, node) <= pe.constants
    }


def _constants(dfg: DFG, node: Node) -> int:
    """Entries of a constant store that the node needs for itself."""
    words: set[tuple[Opcode, int | str | None]] = set()
    for edge in dfg.in_edges[node.id]:
        for source in (edge.src, edge.init):
            if source is None or not edge.is_data:
                continue
            given = dfg.by_id[source]
            if given.op is Opcode.CONST:
                words.add((given.op, given.const))
            elif given.op is Opcode.LIVE_IN:
                words.add((given.op, given.name))
    if node.op is Opcode.LIVE_OUT:
        words.add((Opcode.LIVE_IN, node.name))
    return len(words)


def _check_lower_bound(result: MapResult, proved: int) -> Iterator[Finding]:
    refuted = {item.ii: item.by for item in result.refuted}
    claimed = max([1, *(bound.ii for bound in result.bounds)])
    for ii in range(max(proved, claimed), result.lower_bound):
        if ii in refuted:
            yield Finding("trusted", f"II {ii} refuted by {refuted[ii]}")
        else:
            yield Finding(
                "wrong",
                f"the lower bound {result.lower_bound} is given no reason: nothing refutes II {ii}",
            )
            return
    if result.lower_bound <= proved:
        yield Finding("confirmed", f"the II is at least {result.lower_bound}")


def _check_status(result: MapResult, subject: Subject) -> Iterator[Finding]:
    ii, lower = result.ii, result.lower_bound
    if ii is not None and lower > ii:
        yield Finding("wrong", f"the lower bound {lower} exceeds the II {ii} of the mapping")
    if result.status == "optimal" and (ii is None or lower < ii):
        yield Finding("wrong", f"optimal is claimed at II {ii} with a lower bound of {lower}")
    if (result.status in ("optimal", "feasible")) != (result.mapping is not None):
        held = "no" if result.mapping is None else "a"
        yield Finding("wrong", f"the status is {result.status}, but there is {held} mapping")
    if result.status == "infeasible" and not (result.refuted or lower >= _never(subject)):
        yield Finding("wrong", "infeasible is claimed, but no II is refuted")
