"""The independent verifier: legality of a mapping, re-derived from docs/machine.md alone.

It shares no line with any mapper, so that a mapper's mistake cannot be repeated here, and it
accepts malformed mappings of guests and says what is wrong with them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.mapper.problem import ConstantKey

_Resource = tuple[str, int, int]
"""("link", 0, link) or ("reg", pe, register)."""

_Word = tuple[int, int]
"""(producer, cycle of the producer's iteration)."""

_RES: _Resource = ("res", 0, 0)
"""The place a route starts from: the result in the cycle in which the operation completes."""


@dataclass(frozen=True, slots=True)
class Violation:
    """One broken rule.

    Attributes
    ----------
    kind
        Short name of the rule, for tests and tables: "missing", "issue", "register", ...
    message
        What is wrong, in one sentence.
    nodes
        Ids of the nodes involved.
    """

    kind: str
    message: str
    nodes: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.kind}: {self.message}"


@dataclass(frozen=True)
class _Case:
    """What is verified. `places` holds the nodes whose place makes sense, `latency` theirs."""

    dfg: DFG
    fabric: Fabric
    mapping: Mapping
    places: ReadOnly[int, Place]
    latency: ReadOnly[int, int]

    @property
    def ii(self) -> int:
        return self.mapping.ii

    def slot(self, time: int) -> int:
        return time % self.mapping.ii

    def ready(self, node: int) -> int:
        """First cycle in which the result of `node` can be used."""
        return self.places[node].time + self.latency[node]

    def read_time(self, edge: Edge) -> int:
        """Cycle in which the consumer reads, in the producer's iteration."""
        return self.places[edge.dst].time + self.ii * edge.distance

    def placed(self) -> Iterator[tuple[Node, Place]]:
        for node in self.dfg.placed:
            place = self.places.get(node.id)
            if place is not None:
                yield node, place

    def show(self, node: int) -> str:
        return f"node {node} ({self.dfg.by_id[node].op.value})"


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
    if mapping.ii < 1:
        return [Violation("ii", f"the II is {mapping.ii}; it must be 1 or more")]
    found = list(_placement(dfg, fabric, mapping, allowed or {}))
    places = {n.id: mapping.places[n.id] for n in dfg.placed if _sound(n, fabric, mapping)}
    latency = {n: fabric.latencies[dfg.by_id[n].latency_class] for n in places}
    case = _Case(dfg, fabric, mapping, places, latency)
    found += _issue_and_completion(case)
    found += _controller(case)
    found += _banks(case)
    found += _dependences(case)
    found += _live_outs(case, straight=straight)
    found += _constants(case, resident or {})
    found += _routes(case)
    if straight:
        found += _completes_within_length(case)
    return found


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


# --- FU, controller, dependences ------------------------------------------------------------------


def _issue_and_completion(case: _Case) -> Iterator[Violation]:
    issued: dict[tuple[int, int], list[int]] = defaultdict(list)
    completed: dict[tuple[int, int], list[int]] = defaultdict(list)
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            continue
        issued[place.pe, case.slot(place.time)].append(node.id)
        completed[place.pe, case.slot(case.ready(node.id) - 1)].append(node.id)
    for kind, verb, table in (("issue", "issue", issued), ("completion", "complete", completed)):
        for (pe, slot), nodes in table.items():
            if len(nodes) > 1:
                text = f"nodes {_list(nodes)} {verb} on PE {pe} in slot {slot}"
                yield Violation(kind, text, tuple(nodes))


def _controller(case: _Case) -> Iterator[Violation]:
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
            text = f"control results of nodes {_list(nodes)} reach the controller in slot {slot}"
            yield Violation("control", text, tuple(nodes))


def _banks(case: _Case) -> Iterator[Violation]:
    banks = case.fabric.scratchpad.banks
    accesses: dict[int, list[int]] = defaultdict(list)
    for node, place in case.placed():
        if node.op in (Opcode.LOAD, Opcode.STORE):
            accesses[case.slot(place.time)].append(node.id)
    for slot, nodes in accesses.items():
        if len(nodes) > banks:
            text = f"{len(nodes)} operations access {banks} banks in slot {slot}: {_list(nodes)}"
            yield Violation("banks", text, tuple(nodes))


def _separation(case: _Case, edge: Edge) -> int:
    if edge.kind is EdgeKind.ORDER:
        return 1
    if edge.kind is EdgeKind.CONTROL:
        return case.latency[edge.src] + case.fabric.controller.control_latency
    return case.latency[edge.src]


def _dependences(case: _Case) -> Iterator[Violation]:
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


def _completes_within_length(case: _Case) -> Iterator[Violation]:
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            end = place.time + 1
        elif node.control is not None:
            end = case.ready(node.id) + case.fabric.controller.control_latency
        else:
            end = case.ready(node.id)
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


def _entries_read(case: _Case, node: Node) -> Iterator[ConstantKey]:
    for edge in case.dfg.in_edges[node.id]:
        if edge.kind is not EdgeKind.DATA:
            continue
        for source in (edge.src, edge.init):
            entry = None if source is None else _entry(case.dfg.by_id[source])
            if entry is not None:
                yield entry


def _constants(
    case: _Case, resident: ReadOnly[int, Collection[ConstantKey]]
) -> Iterator[Violation]:
    entries = {pe.id: set(resident.get(pe.id, ())) for pe in case.fabric.pes}
    users: dict[int, list[int]] = defaultdict(list)
    for node, place in case.placed():
        needed = set(_entries_read(case, node))
        if node.op is Opcode.LIVE_OUT:
            needed.add(("live_in", node.name))
        entries[place.pe] |= needed
        if needed:
            users[place.pe].append(node.id)
    for pe, nodes in users.items():
        capacity = case.fabric.pes[pe].constants
        if len(entries[pe]) > max(capacity, len(resident.get(pe, ()))):
            text = f"the constant store of PE {pe} would hold {len(entries[pe])} of {capacity}"
            yield Violation("constants", text, tuple(nodes))


def _live_outs(case: _Case, *, straight: bool) -> Iterator[Violation]:
    writes: dict[tuple[int, int], list[int]] = defaultdict(list)
    for node, place in case.placed():
        if node.op is Opcode.LIVE_OUT:
            writes[place.pe, case.slot(place.time)].append(node.id)
            yield from _not_from_an_fu(case, node)
            yield from _old_word_lost(case, node, place, straight=straight)
    for (pe, slot), nodes in writes.items():
        if len(nodes) > 1:
            text = f"live-outs {_list(nodes)} write the constant store of PE {pe} in slot {slot}"
            yield Violation("live_out", text, tuple(nodes))


def _not_from_an_fu(case: _Case, live_out: Node) -> Iterator[Violation]:
    """A constant store is written from the crossbar, never from constants or the controller."""
    for edge in case.dfg.in_edges[live_out.id]:
        if edge.kind is EdgeKind.DATA and case.dfg.by_id[edge.src].is_source:
            text = f"{case.show(live_out.id)} reads {case.show(edge.src)}, not an operation"
            yield Violation("live_out", text, (edge.src, live_out.id))


def _old_word_lost(
    case: _Case, live_out: Node, place: Place, *, straight: bool
) -> Iterator[Violation]:
    """Reads of a variable see the word from before the region: none may follow a write."""
    entry = ("live_in", live_out.name)
    for node, reader in case.placed():
        if reader.pe != place.pe or (straight and reader.time <= place.time):
            continue
        if entry in _entries_read(case, node):
            where = f"{live_out.name!r} on PE {place.pe}"
            text = f"{case.show(node.id)} reads {where} after it is written"
            yield Violation("live_in", text, (live_out.id, node.id))


# --- routes ---------------------------------------------------------------------------------------


def _routes(case: _Case) -> Iterator[Violation]:
    routed = dict(case.dfg.routed_edges())
    for index in sorted(case.mapping.routes.keys() - routed.keys()):
        yield Violation("route", f"there is a route for edge {index}, which needs none")
    traffic = _Traffic(case)
    for index, edge in routed.items():
        route = case.mapping.routes.get(index)
        if route is None:
            text = f"edge {index} ({edge.src} -> {edge.dst}) has no route"
            yield Violation("route", text, (edge.src, edge.dst))
            continue
        if edge.src not in case.places or edge.dst not in case.places:
            continue
        faults = list(_route_faults(case, edge, tuple(route)))
        for fault in faults:
            text = f"edge {index} ({edge.src} -> {edge.dst}): {fault}"
            yield Violation("route", text, (edge.src, edge.dst))
        if not faults:
            traffic.add(edge.src, tuple(route))
    yield from traffic.conflicts()


def _route_faults(case: _Case, edge: Edge, route: tuple[Step, ...]) -> Iterator[str]:
    """What is wrong with one route by itself, up to the first faulty step."""
    producer, consumer = case.places[edge.src], case.places[edge.dst]
    ready, read = case.ready(edge.src), case.read_time(edge)
    if case.dfg.by_id[edge.src].op is Opcode.LIVE_OUT:
        yield "a live-out has no result"
        return
    if not route:
        if producer.pe != consumer.pe:
            yield f"no steps lead from PE {producer.pe} to PE {consumer.pe}"
        if read != ready:
            yield f"the output register holds the word in cycle {ready}, it is read in {read}"
        return
    before: Step | None = None
    for time, step in enumerate(route, start=ready):
        fault = _step_fault(case.fabric, step, time)
        if fault is None:
            fault = _move_fault(case.fabric, producer.pe, before, step)
        if fault is not None:
            yield f"step {time - ready} {fault}"
            return
        before = step
    last = route[-1]
    if last.time != read:
        yield f"the last step is in cycle {last.time}, the consumer reads in {read}"
    if last.pe != consumer.pe:
        yield f"the last step is on PE {last.pe}, the consumer on PE {consumer.pe}"


def _step_fault(fabric: Fabric, step: Step, time: int) -> str | None:
    """A step that cannot be, wherever the word comes from."""
    if step.time != time:
        return f"is in cycle {step.time}, not in {time}"
    if step.kind == "link":
        return _link_fault(fabric, step)
    if step.kind != "reg":
        return f"has the unknown kind {step.kind!r}"
    if not 0 <= step.pe < len(fabric.pes):
        return f"names PE {step.pe}, which does not exist"
    if not 0 <= step.index < fabric.pes[step.pe].registers:
        return f"names register {step.index} of PE {step.pe}, which does not exist"
    return None


def _link_fault(fabric: Fabric, step: Step) -> str | None:
    if not 0 <= step.index < len(fabric.links):
        return f"names link {step.index}, which does not exist"
    end = fabric.links[step.index].dst
    return None if end == step.pe else f"says PE {step.pe}; link {step.index} ends at {end}"


def _move_fault(fabric: Fabric, start_pe: int, before: Step | None, step: Step) -> str | None:
    """A step that the word cannot make from the PE where it is readable."""
    on_pe = start_pe if before is None else before.pe
    if step.kind == "link" and fabric.links[step.index].src != on_pe:
        leaves = fabric.links[step.index].src
        return f"takes link {step.index}, which leaves PE {leaves}; the word is on PE {on_pe}"
    if step.kind == "reg" and step.pe != on_pe:
        return f"writes a register of PE {step.pe}; the word is on PE {on_pe}"
    return None


def _resource(step: Step) -> _Resource:
    return ("link", 0, step.index) if step.kind == "link" else ("reg", step.pe, step.index)


@dataclass
class _Traffic:
    """All well-formed routes together: who is where in which slot, and the ports in use."""

    case: _Case
    words: dict[tuple[_Resource, int], dict[_Word, set[_Resource]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )
    reads: dict[tuple[int, int], dict[int, set[int]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )
    writes: dict[tuple[int, int], dict[int, set[int]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )

    def add(self, value: int, route: tuple[Step, ...]) -> None:
        """Enter the places of one route, with the place that drives each."""
        before: Step | None = None
        for step in route:
            came_from = _RES if before is None else _resource(before)
            here = _resource(step)
            self.words[here, self.case.slot(step.time)][value, step.time].add(came_from)
            if came_from != here:
                self._read(value, before)
                self._write(value, step)
            before = step
        self._read(value, before)

    def _read(self, value: int, step: Step | None) -> None:
        if step is not None and step.kind == "reg":
            self.reads[step.pe, self.case.slot(step.time)][step.index].add(value)

    def _write(self, value: int, step: Step) -> None:
        if step.kind == "reg":
            self.writes[step.pe, self.case.slot(step.time - 1)][step.index].add(value)

    def conflicts(self) -> Iterator[Violation]:
        """Resources that two words need at once, two drivers of one word, and too few ports."""
        yield from self._clashes()
        yield from self._ports("read", self.reads, [p.read_ports for p in self.case.fabric.pes])
        yield from self._ports("write", self.writes, [p.write_ports for p in self.case.fabric.pes])

    def _clashes(self) -> Iterator[Violation]:
        for (resource, slot), words in self.words.items():
            nodes = tuple(sorted({node for node, _ in words}))
            if len(words) > 1:
                kind = "link" if resource[0] == "link" else "register"
                held = ", ".join(f"node {node} of cycle {time}" for node, time in sorted(words))
                text = f"{_name(resource)} carries more than one word in slot {slot}: {held}"
                yield Violation(kind, text, nodes)
            for (node, time), drivers in words.items():
                if len(drivers) > 1:
                    sources = ", ".join(_name(driver) for driver in sorted(drivers))
                    text = f"{_name(resource)} takes node {node} in cycle {time - 1} from {sources}"
                    yield Violation("driver", text, (node,))

    def _ports(
        self, verb: str, table: dict[tuple[int, int], dict[int, set[int]]], ports: list[int]
    ) -> Iterator[Violation]:
        for (pe, slot), registers in table.items():
            if len(registers) > ports[pe]:
                text = (
                    f"PE {pe} has {ports[pe]} {verb} ports; registers {_list(sorted(registers))} "
                    f"are to be {'read' if verb == 'read' else 'written'} in slot {slot}"
                )
                nodes = sorted(set().union(*registers.values()))
                yield Violation(f"{verb}_ports", text, tuple(nodes))


def _name(resource: _Resource) -> str:
    kind, pe, index = resource
    if kind == "res":
        return "the FU's result"
    return f"link {index}" if kind == "link" else f"register {index} of PE {pe}"


def _list(items: Iterable[int]) -> str:
    return ", ".join(str(item) for item in items)
