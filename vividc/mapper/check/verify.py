"""The independent verifier: legality of a mapping, re-derived from docs/machine.md alone.

It shares no line with any mapper, so that a mapper's mistake cannot be repeated here, and it
accepts malformed mappings of guests and says what is wrong with them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from collections.abc import Mapping as ReadOnly

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import demand_type
from vividc.machine.opcodes import Opcode
from vividc.mapper.check.case import Case, Violation, listed
from vividc.mapper.check.routes import Moves, route_violations
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.problem import ConstantKey


def violations(
    dfg: DFG,
    fabric: Fabric,
    mapping: Mapping,
    *,
    allowed: ReadOnly[int, Collection[int]] | None = None,
    resident: ReadOnly[int, Collection[ConstantKey]] | None = None,
    straight: bool = False,
) -> list[Violation]:
    """Every rule of the machine that `mapping` breaks; empty when it is legal.

    Parameters
    ----------
    dfg, fabric
        What was mapped and onto what. The DFG is taken to be well-formed.
    mapping
        Any mapping, malformed ones included. Rules about nodes or routes that make no sense by
        themselves are reported once and left out of the sharing of resources.
    allowed
        PEs that a node may lie on, by node id; nodes not named are free.
    resident
        Constant-store entries that other regions hold, by PE.
    straight
        The region runs once: II is its length and all must complete within it.
    """
    demand_type(dfg, DFG, "the DFG", "load one with vividc.dfg.load")
    demand_type(fabric, Fabric, "the fabric", "load one with vividc.arch.load")
    demand_type(mapping, Mapping, "the mapping", "take `.mapping` of a MapResult")
    if mapping.ii < 1:
        return [Violation("ii", f"the II is {mapping.ii}; it must be 1 or more")]
    faults = list(_placement(dfg, fabric, mapping, allowed or {}))
    places = {n.id: mapping.places[n.id] for n in dfg.placed if _sound(n, fabric, mapping)}
    latency = {n: fabric.latencies[dfg.by_id[n].latency_class] for n in places}
    case = Case(dfg, fabric, mapping, places, latency)
    route_faults, moves = route_violations(case)
    faults += _issue_and_completion(case, moves)
    faults += _controller(case)
    faults += _banks(case)
    faults += _dependences(case)
    faults += _live_outs(case, straight=straight)
    faults += _constants(case, resident or {})
    faults += route_faults
    if straight:
        faults += _completes_within_length(case)
    return faults


verify = violations


# --- places ---------------------------------------------------------------------------------------


def _sound(node: Node, fabric: Fabric, mapping: Mapping) -> bool:
    place = mapping.places.get(node.id)
    if place is None or not 0 <= place.pe < len(fabric.pes) or place.time < 0:
        return False
    return node.latency_class in fabric.latencies


def _placement(
    dfg: DFG, fabric: Fabric, mapping: Mapping, allowed: ReadOnly[int, Collection[int]]
) -> Iterator[Violation]:
    must_place = {node.id for node in dfg.placed}
    for node_id in sorted(mapping.places.keys() - must_place):
        yield Violation("unknown", f"node {node_id} is placed but is not to be placed", (node_id,))
    for node in dfg.placed:
        place = mapping.places.get(node.id)
        if place is None:
            yield Violation("missing", f"node {node.id} ({node.op.value}) has no place", (node.id,))
            continue
        for kind, reason in _place_faults(node, place, fabric, allowed):
            yield Violation(kind, f"node {node.id} ({node.op.value}) {reason}", (node.id,))


def _place_faults(
    node: Node, place: Place, fabric: Fabric, allowed: ReadOnly[int, Collection[int]]
) -> Iterator[tuple[str, str]]:
    if place.time < 0:
        yield "time", f"issues at cycle {place.time}, before its iteration"
    if not 0 <= place.pe < len(fabric.pes):
        yield "pe", f"lies on PE {place.pe}; the fabric has PEs 0 to {len(fabric.pes) - 1}"
        return
    if node.id in allowed and place.pe not in allowed[node.id]:
        yield "allowed", f"lies on PE {place.pe}, which is not permitted to it"
    if node.latency_class not in fabric.latencies:
        yield "op", f"has no latency on fabric {fabric.name}"
    if node.op is Opcode.LIVE_OUT:
        return
    if node.latency_class not in fabric.pes[place.pe].classes:
        yield "op", f"lies on PE {place.pe}, whose FU has no {node.latency_class.value}"
    elif node.info.sliced and not fabric.pes[place.pe].sliced:
        yield "op", f"lies on PE {place.pe}, whose FU has no slices for 16 or 8 bits"


# --- FU, controller, dependences ------------------------------------------------------------------


def _issue_and_completion(case: Case, moves: Moves) -> Iterator[Violation]:
    issued: dict[tuple[int, int], list[int]] = defaultdict(list)
    completed: dict[tuple[int, int], list[int]] = defaultdict(list)
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            continue
        for cycle in range(case.fabric.occupancies.get(node.latency_class, 1)):
            issued[place.pe, case.slot(place.time + cycle)].append(node.id)
        completed[place.pe, case.slot(case.ready(node.id) - 1)].append(node.id)
    for (pe, time), words in moves.items():
        issued[pe, case.slot(time)] += words
        completed[pe, case.slot(time)] += words
    for kind, verb, table in (("issue", "issue", issued), ("completion", "complete", completed)):
        for (pe, slot), nodes in table.items():
            if len(nodes) > 1:
                text = f"nodes {listed(nodes)} {verb} on PE {pe} in slot {slot}"
                yield Violation(kind, text, tuple(nodes))


def _controller(case: Case) -> Iterator[Violation]:
    limits = case.fabric.controller
    if case.ii > limits.contexts:
        yield Violation("contexts", f"II {case.ii} exceeds the {limits.contexts} contexts")
    for node, place in case.placed():
        stage = place.time // case.ii
        if stage >= limits.max_stages:
            text = f"{case.show(node.id)} is in stage {stage}; there are {limits.max_stages} stages"
            yield Violation("stages", text, (node.id,))
    results: dict[int, list[int]] = defaultdict(list)
    for node, _ in case.placed():
        if node.control is not None:
            results[case.slot(case.ready(node.id) - 1)].append(node.id)
    for slot, nodes in results.items():
        if len(nodes) > 1:
            text = f"control results of nodes {listed(nodes)} reach the controller in slot {slot}"
            yield Violation("control", text, tuple(nodes))


def _banks(case: Case) -> Iterator[Violation]:
    banks = case.fabric.scratchpad.banks
    accesses: dict[int, list[int]] = defaultdict(list)
    for node, place in case.placed():
        if node.op in (Opcode.LOAD, Opcode.STORE):
            accesses[case.slot(place.time)].append(node.id)
    for slot, nodes in accesses.items():
        if len(nodes) > banks:
            text = f"{len(nodes)} operations access {banks} banks in slot {slot}: {listed(nodes)}"
            yield Violation("banks", text, tuple(nodes))


def _separation(case: Case, edge: Edge) -> int:
    if edge.kind is EdgeKind.ORDER:
        return 1
    if edge.kind is EdgeKind.CONTROL:
        return case.latency[edge.src] + case.fabric.controller.control_latency
    return case.latency[edge.src]


def _dependences(case: Case) -> Iterator[Violation]:
    for edge in case.dfg.edges:
        if edge.src not in case.places or edge.dst not in case.places:
            continue
        earliest = case.places[edge.src].time + _separation(case, edge)
        if case.read_time(edge) < earliest:
            text = (
                f"{case.show(edge.dst)} comes {earliest - case.read_time(edge)} cycles too early "
                f"after {case.show(edge.src)} ({edge.kind.value} edge, distance {edge.distance})"
            )
            yield Violation("dependence", text, (edge.src, edge.dst))


def _completes_within_length(case: Case) -> Iterator[Violation]:
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            end = place.time + 1
        elif node.control is not None:
            end = case.ready(node.id) + case.fabric.controller.control_latency
        else:
            end = case.ready(node.id)
        end = max(end, place.time + case.fabric.occupancies.get(node.latency_class, 1))
        if end > case.ii:
            text = f"{case.show(node.id)} ends after {end} cycles; the region has {case.ii}"
            yield Violation("straight", text, (node.id,))
    for edge in case.dfg.edges:
        if edge.distance != 0:
            text = f"edge {edge.src} -> {edge.dst} of a straight region has a distance"
            yield Violation("straight", text, (edge.src, edge.dst))


# --- constant stores ------------------------------------------------------------------------------


def _entry(node: Node) -> ConstantKey | None:
    if node.op is Opcode.CONST:
        return ("const", 0 if node.const is None else node.const)
    return ("live_in", node.name) if node.op is Opcode.LIVE_IN else None


def _entries_read(dfg: DFG, node: Node) -> Iterator[ConstantKey]:
    for edge in dfg.in_edges[node.id]:
        if edge.kind is not EdgeKind.DATA:
            continue
        for source in (edge.src, edge.init):
            entry = None if source is None else _entry(dfg.by_id[source])
            if entry is not None:
                yield entry


def entries_needed(dfg: DFG, node: Node) -> set[ConstantKey]:
    """Entries of the constant store of its PE that a node reads or writes."""
    needed = set(_entries_read(dfg, node))
    if node.op is Opcode.LIVE_OUT:
        needed.add(("live_in", node.name))
    return needed


def _constants(case: Case, resident: ReadOnly[int, Collection[ConstantKey]]) -> Iterator[Violation]:
    entries = {pe.id: set(resident.get(pe.id, ())) for pe in case.fabric.pes}
    users: dict[int, list[int]] = defaultdict(list)
    for node, place in case.placed():
        needed = entries_needed(case.dfg, node)
        entries[place.pe] |= needed
        if needed:
            users[place.pe].append(node.id)
    for pe, nodes in users.items():
        capacity = case.fabric.pes[pe].constants
        if len(entries[pe]) > max(capacity, len(resident.get(pe, ()))):
            text = f"the constant store of PE {pe} would hold {len(entries[pe])} of {capacity}"
            yield Violation("constants", text, tuple(nodes))


def _live_outs(case: Case, *, straight: bool) -> Iterator[Violation]:
    writes: dict[tuple[int, int], list[int]] = defaultdict(list)
    readers: dict[tuple[int, ConstantKey], list[int]] = defaultdict(list)
    for node, place in case.placed():
        for entry in set(_entries_read(case.dfg, node)):
            readers[place.pe, entry].append(node.id)
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            writes[place.pe, case.slot(place.time)].append(node.id)
            yield from _not_from_an_fu(case, node)
            reading = readers.get((place.pe, ("live_in", node.name)), ())
            yield from _old_word_lost(case, node, place, reading, straight=straight)
    for (pe, slot), nodes in writes.items():
        if len(nodes) > 1:
            text = f"live-outs {listed(nodes)} write the constant store of PE {pe} in slot {slot}"
            yield Violation("live_out", text, tuple(nodes))


def _not_from_an_fu(case: Case, live_out: Node) -> Iterator[Violation]:
    """A constant store is written from the crossbar, never from constants or the controller."""
    for edge in case.dfg.in_edges[live_out.id]:
        if edge.kind is EdgeKind.DATA and case.dfg.by_id[edge.src].is_source:
            text = f"{case.show(live_out.id)} reads {case.show(edge.src)}, not an operation"
            yield Violation("live_out", text, (edge.src, live_out.id))


def _old_word_lost(
    case: Case, live_out: Node, place: Place, reading: Collection[int], *, straight: bool
) -> Iterator[Violation]:
    """Nodes `reading` a variable on the PE where it is written see the word from before the region:
    none may follow the write.
    """
    for node in reading:
        if straight and case.places[node].time <= place.time:
            continue
        where = f"{live_out.name!r} on PE {place.pe}"
        text = f"{case.show(node)} reads {where} after it is written"
        yield Violation("live_in", text, (live_out.id, node))
