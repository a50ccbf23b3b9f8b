"""Checks bounds on the II without a solver: each is derived again from the graph and the fabric,
given only the nodes and edges that are said to bind. It shares no line with `bounds`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.check.finding import Finding, own_words
from vividc.mapper.check.lives import least_sum_of_lives, places_for_words, separation
from vividc.mapper.check.reach import connected, readable_from
from vividc.mapper.check.verify import entries_needed
from vividc.mapper.mapping import Bound, Subject

_SHOWN: Final = 6


def check_bounds(bounds: Sequence[Bound], subject: Subject) -> tuple[Finding, ...]:
    """A finding for each bound: "confirmed" in the words of its check, or "wrong"."""
    findings: dict[int, Finding] = {}
    proved = 1
    for number in sorted(range(len(bounds)), key=lambda at: bounds[at].name == _LIVES):
        findings[number] = _check(_Claim(bounds[number], subject, proved))
        if findings[number].verdict == "confirmed":
            proved = max(proved, bounds[number].ii)
    return tuple(findings[number] for number in range(len(bounds)))


@dataclass(frozen=True)
class _Claim:
    """A bound on the II of a subject; `proved`: the II that other bounds prove."""

    bound: Bound
    subject: Subject
    proved: int

    @property
    def dfg(self) -> DFG:
        return self.subject.dfg

    @property
    def fabric(self) -> Fabric:
        return self.subject.fabric

    @property
    def users(self) -> list[Node]:
        """The nodes that are said to bind, each once."""
        return [self.dfg.by_id[node] for node in dict.fromkeys(self.bound.nodes)]

    @property
    def says_no_ii(self) -> bool:
        """The bound is one more than the contexts, which stands for "no II works"."""
        return self.bound.ii == self.fabric.controller.contexts + 1

    def exceeds(self, cycles: int, units: int) -> bool:
        """At the II below, `units` have room for fewer than `cycles`."""
        return cycles > (self.bound.ii - 1) * units


def _check(claim: _Claim) -> Finding:
    bound = claim.bound
    text = f"{own_words(bound.name)} {bound.ii}: "
    given = f"{text}{own_words(bound.reason)}"
    unknown = [node for node in bound.nodes if node not in claim.dfg.by_id]
    if unknown:
        return Finding("wrong", f"{given} (the graph has no node {unknown[0]})")
    check = _CHECKS.get(bound.name)
    if check is None:
        return Finding("wrong", f"{given} (no bound of this name is known)")
    if (bound.edges or bound.distance) and check is not _recurrence:
        return Finding("wrong", f"{given} (edges and a distance are those of a recurrence)")
    why = check(claim)
    if why is None:
        return Finding("wrong", f"{given} (does not follow from the graph and the fabric)")
    return Finding("confirmed", text + why)


def _shown(nodes: Sequence[Node]) -> str:
    names = ", ".join(_name(node) for node in nodes[:_SHOWN])
    return names if len(nodes) <= _SHOWN else f"{names}, and {len(nodes) - _SHOWN} more"


def _name(node: Node) -> str:
    kind = node.name if node.op is Opcode.GENERIC and node.name else node.op.value
    label = f" ({own_words(node.label)})" if node.label else ""
    return f"{own_words(kind)} #{node.id}{label}"


# --- recurrences and paths ------------------------------------------------------------------------


def _recurrence(claim: _Claim) -> str | None:
    edges = _cycle(claim)
    latency = sum(separation(edge, claim.subject) for edge in edges)
    distance = sum(edge.distance for edge in edges)
    cited = bool(claim.bound.edges) or claim.bound.distance != 0
    if not edges or (cited and claim.bound.distance != distance):
        return None
    around = " -> ".join(_name(claim.dfg.by_id[edge.src]) for edge in [*edges, edges[0]])
    if distance == 0:
        return f"cycle of distance 0: {around}" if latency > 0 and claim.says_no_ii else None
    if not claim.exceeds(latency, distance):
        return None
    return f"{latency} cycles over distance {distance}: {around}"


def _cycle(claim: _Claim) -> list[Edge]:
    """The edges along the nodes, in a cycle; empty if there is no such cycle.

    Where none are named, the edge is taken between two nodes that binds most at the II below.
    """
    nodes, every = claim.bound.nodes, claim.dfg.edges
    steps = list(zip(nodes, [*nodes[1:], *nodes[:1]], strict=True))
    if claim.bound.edges:
        edges = [every[index] for index in claim.bound.edges if 0 <= index < len(every)]
        named = [(edge.src, edge.dst) for edge in edges]
        return edges if named == steps and len(edges) == len(claim.bound.edges) else []
    cycle = []
    for step in steps:
        parallel = [edge for edge in every if (edge.src, edge.dst) == step]
        if not parallel:
            return []
        cycle.append(max(parallel, key=lambda edge: _weight(edge, claim)))
    return cycle


def _weight(edge: Edge, claim: _Claim) -> int:
    """Least cycles between the starts of an edge's ends, at the II below the bound."""
    return separation(edge, claim.subject) - (claim.bound.ii - 1) * edge.distance


def _stages(claim: _Claim) -> str | None:
    """At the II below, the longest path leaves the stages, or there is no longest path."""
    stages = claim.fabric.controller.max_stages
    start = {node.id: 0 for node in claim.dfg.placed}
    edges = [edge for edge in claim.dfg.edges if edge.src in start]
    for _ in range(len(start) + 1):
        before = dict(start)
        for edge in edges:
            start[edge.dst] = max(start[edge.dst], start[edge.src] + _weight(edge, claim))
        if start == before:
            break
    else:
        return "at the II below a recurrence has no schedule"
    longest = max(start.values(), default=0)
    if longest < stages * (claim.bound.ii - 1):
        return None
    return f"at the II below the longest path takes {longest} cycles; there are {stages} stages"


# --- FUs, ports and banks -------------------------------------------------------------------------


def _issue(claim: _Claim) -> str | None:
    users = [node for node in claim.users if node.uses_fu]
    cycles, pes = _cycles(users, claim), _pes_of(users, claim.subject)
    if not claim.exceeds(cycles, len(pes)):
        return None
    return f"{cycles} cycles of an FU on {_counted(len(pes), 'PE')}: {_shown(users)}"


def _cycles(nodes: Sequence[Node], claim: _Claim) -> int:
    return sum(claim.fabric.occupancy(node) for node in nodes if node.uses_fu)


def _occupancy(claim: _Claim) -> str | None:
    """An operation cannot issue again before it leaves its FU."""
    kept = [claim.fabric.occupancy(node) for node in claim.users if node.uses_fu]
    longest = max(kept, default=1)
    if longest < claim.bound.ii:
        return None
    return f"an operation keeps its FU for {longest} cycles: {_shown(claim.users)}"


def _live_outs(claim: _Claim) -> str | None:
    users = [node for node in claim.users if node.op is Opcode.LIVE_OUT]
    pes = _pes_of(users, claim.subject)
    if not claim.exceeds(len(users), len(pes)):
        return None
    return f"{len(users)} live-outs on {_counted(len(pes), 'PE')}: {_shown(users)}"


def _control(claim: _Claim) -> str | None:
    users = [node for node in claim.users if node.control is not None]
    return f"one control result a cycle: {_shown(users)}" if len(users) >= claim.bound.ii else None


def _banks(claim: _Claim) -> str | None:
    users = [node for node in claim.users if node.is_memory]
    banks = claim.fabric.scratchpad.banks
    if not claim.exceeds(len(users), banks):
        return None
    return f"{len(users)} accesses to {_counted(banks, 'bank')}: {_shown(users)}"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


# --- what no II can do ----------------------------------------------------------------------------


def _placement(claim: _Claim) -> str | None:
    nowhere = [node for node in claim.users if not _pes_of([node], claim.subject)]
    return f"no PE can take {_shown(nowhere)}" if nowhere and claim.says_no_ii else None


def _lifetime(claim: _Claim) -> str | None:
    """More instances of one word are alive than there are places for words."""
    fabric = claim.fabric
    links = len(fabric.links) if fabric.routing.hops else 0
    places = links + sum(pe.registers + 1 for pe in fabric.pes)
    alive = [
        edge.distance - fabric.controller.max_stages - separation(edge, claim.subject)
        for edge in claim.dfg.edges
        if edge.is_data and (edge.src, edge.dst) == claim.bound.nodes
    ]
    most = max(alive, default=0)
    if most <= places or not claim.says_no_ii:
        return None
    return f"{most} words of {_name(claim.users[0])} are alive at once, in {places} places"


def _entry(claim: _Claim) -> str | None:
    """A live-out's operand, or its word before the first iteration, is the entry it writes."""
    for node in claim.users:
        own = Opcode.LIVE_IN, node.name
        for source in _sources(claim.dfg, node):
            if node.op is Opcode.LIVE_OUT and (source.op, source.name) == own:
                return f"{_name(node)} reads the entry it writes" if claim.says_no_ii else None
    return None


def _sources(dfg: DFG, node: Node) -> Iterator[Node]:
    for edge in dfg.in_edges[node.id]:
        for origin in (edge.src, edge.init) if edge.is_data else ():
            if origin is not None:
                yield dfg.by_id[origin]


def _operands(claim: _Claim) -> str | None:
    """Of one cycle: a word from each link, each read port, each output register within reach."""
    if len(claim.users) != 1 or not claim.says_no_ii:
        return None
    node, fabric, most = claim.users[0], claim.fabric, 0
    words = {
        (edge.src, edge.distance)
        for edge in claim.dfg.in_edges[node.id]
        if edge.is_data and not claim.dfg.by_id[edge.src].is_source
    }
    for pe in _pes_of([node], claim.subject):
        into = sum(link.dst == pe for link in fabric.links)
        file = fabric.pes[pe]
        here = 1 + min(file.registers, file.read_ports) + into * bool(fabric.routing.hops)
        most = max(most, here + into * fabric.routing.shared)
    if len(words) <= most:
        return None
    return f"{_name(node)} reads {len(words)} words at once, {most} come to a PE"


# --- where words can get --------------------------------------------------------------------------


def _reach(claim: _Claim) -> str | None:
    """PEs without a partner at the other end of some edge are struck out until none is left."""
    reach = readable_from(claim.fabric)
    left = {node.id: _pes_of([node], claim.subject) for node in claim.dfg.placed}
    edges = [edge for _, edge in claim.dfg.routed_edges()]
    changed = True
    while changed:
        changed = False
        for edge in edges:
            src = {pe for pe in left[edge.src] if reach[pe] & left[edge.dst]}
            dst = {pe for pe in left[edge.dst] if any(pe in reach[start] for start in src)}
            changed = changed or (src, dst) != (left[edge.src], left[edge.dst])
            left[edge.src], left[edge.dst] = src, dst
    stuck = [node for node in claim.users if not left.get(node.id, {0})]
    if not stuck or not claim.says_no_ii:
        return None
    return f"on no PE all words get to {_shown(stuck)} and on from there"


def _island(claim: _Claim) -> str | None:
    """Nodes connected by words lie on one island of PEs and share its FUs."""
    group = {node.id for node in claim.users}
    joins = [(e.src, e.dst) for _, e in claim.dfg.routed_edges() if {e.src, e.dst} <= group]
    if len(connected(group, joins)) != 1:
        return None
    joined = [(pe, to) for pe, ends in enumerate(readable_from(claim.fabric)) for to in ends]
    sizes = [
        len(island)
        for island in connected({pe.id for pe in claim.fabric.pes}, joined)
        if all(_pes_of([node], claim.subject) & island for node in claim.users)
    ]
    most = max(sizes, default=0)
    if not claim.exceeds(_cycles(claim.users, claim), most):
        return None
    return f"{len(group)} nodes joined by words, on islands of {_counted(most, 'PE')} at most"


def _lives(claim: _Claim) -> str | None:
    """At each II from the one that other bounds prove, words live too long for the places."""
    if claim.bound.ii > claim.fabric.controller.contexts + 1:
        return None
    places = places_for_words(claim.fabric)
    life: int | None = 0
    for ii in range(claim.proved, claim.bound.ii):
        life = least_sum_of_lives(claim.subject, ii)
        if life is not None and life <= ii * places:
            return None
    if claim.bound.ii <= claim.proved or life is None:
        return "at each smaller II some other bound binds"
    room = (claim.bound.ii - 1) * places
    return f"at the II below words live {life} cycles or more in all, with room for {room}"


_LIVES: Final = "register pressure"
_CHECKS: Final[dict[str, Callable[[_Claim], str | None]]] = {
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
    "reach": _reach,
    "island": _island,
    _LIVES: _lives,
}


def _pes_of(users: Sequence[Node], subject: Subject) -> set[int]:
    """PEs that can take any of the users."""
    return {pe.id for node in users for pe in subject.fabric.pes if _takes(pe.id, node, subject)}


def _takes(pe: int, node: Node, subject: Subject) -> bool:
    if not subject.fabric.supports(pe, node) or pe not in subject.allowed.get(node.id, (pe,)):
        return False
    held = set(subject.resident.get(pe, ()))
    room = max(subject.fabric.pes[pe].constants, len(held))
    return len(held | entries_needed(subject.dfg, node)) <= room
