"""The verifier on routes: each by itself, then all together on links, registers and ports."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Edge
from vividc.machine.opcodes import Opcode
from vividc.mapper.check.case import Case, Violation, listed
from vividc.mapper.mapping import Step

_Resource = tuple[str, int, int]
"""("link", 0, link), ("reg", pe, register) or ("out", pe, 0); as a source also ("wire", 0, link), a
link in the cycle in which it is driven.
"""

_Word = tuple[int, int]
"""(producer, cycle of the producer's iteration)."""

_RES: _Resource = ("res", 0, 0)
"""The place a route starts from: the result in the cycle in which the operation completes."""


Moves = ReadOnly[tuple[int, int], Collection[int]]
"""Producers of the words that an FU moves, by (PE, cycle of the producer's iteration)."""


def route_violations(case: Case) -> tuple[list[Violation], Moves]:
    """Faulty routes, and sound ones that need one resource at once; and what the FUs move."""
    traffic = _Traffic(case)
    faults = [*_faulty_routes(case, traffic)]
    traffic.add_results()
    return [*faults, *traffic.conflicts()], traffic.moves


def carrying(case: Case) -> tuple[int, int]:
    """Of legal routes: links driven and moves made for an iteration, each word once however many
    read it; and registers in use, of each file the most in a slot, added up.
    """
    traffic = _Traffic(case)
    for _ in _faulty_routes(case, traffic):
        pass
    links, held = 0, defaultdict[tuple[int, int], int](int)
    for ((kind, pe, _), slot), words in traffic.words.items():
        links += len(words) if kind == "link" else 0
        held[pe, slot] += len(words) if kind == "reg" else 0
    most: dict[int, int] = {}
    for (pe, _), count in held.items():
        most[pe] = max(count, most.get(pe, 0))
    moves = sum(len(words) for words in traffic.moves.values())
    return links + moves, sum(most.values())


def _faulty_routes(case: Case, traffic: _Traffic) -> Iterator[Violation]:
    """What is wrong with each route by itself; sound routes enter `traffic`."""
    routed = dict(case.dfg.routed_edges())
    for index in sorted(case.mapping.routes.keys() - routed.keys()):
        yield Violation("route", f"there is a route for edge {index}, which needs none")
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


def _route_faults(case: Case, edge: Edge, route: tuple[Step, ...]) -> Iterator[str]:
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
    fault = _walk_fault(case.fabric, producer.pe, ready, route)
    if fault is not None:
        yield fault
        return
    last = route[-1]
    if last.time != read:
        yield f"the last step is in cycle {last.time}, the consumer reads in {read}"
    if consumer.pe not in _readers(case.fabric, last):
        yield f"the last step is on PE {last.pe}, the consumer on PE {consumer.pe}"


def _walk_fault(fabric: Fabric, start_pe: int, ready: int, route: tuple[Step, ...]) -> str | None:
    """What is wrong with the first faulty step."""
    before: Step | None = None
    hops, time = 0, ready
    for number, step in enumerate(route):
        hops = hops + 1 if before is not None and _passes_on(before, step) else 1
        if number and hops == 1:
            time += 1
        fault = _step_fault(fabric, step, time, hops) or _move_fault(fabric, start_pe, before, step)
        if fault is not None:
            return f"step {number} {fault}"
        before = step
    return None


def _passes_on(before: Step, step: Step) -> bool:
    """A word takes both links in one cycle."""
    return before.kind == "link" and step.kind == "link" and step.time == before.time


def _readers(fabric: Fabric, step: Step) -> tuple[int, ...]:
    """PEs that can read the word where it is."""
    if step.kind == "out" and fabric.routing.shared:
        return (step.pe, *(link.dst for link in fabric.links if link.src == step.pe))
    return (step.pe,)


def _step_fault(fabric: Fabric, step: Step, time: int, hops: int) -> str | None:
    """A step that is impossible, wherever the word comes from."""
    if step.time != time:
        return f"is in cycle {step.time}, not in {time}"
    if step.kind == "link":
        return _link_fault(fabric, step, hops)
    if step.kind not in ("reg", "out"):
        return f"has the unknown kind {step.kind!r}"
    if not 0 <= step.pe < len(fabric.pes):
        return f"names PE {step.pe}, which does not exist"
    if not 0 <= step.index < (1 if step.kind == "out" else fabric.pes[step.pe].registers):
        return f"names register {step.index} of PE {step.pe}, which does not exist"
    return None


def _link_fault(fabric: Fabric, step: Step, hops: int) -> str | None:
    if hops > fabric.routing.hops:
        return f"is link {hops} of one cycle; words pass {fabric.routing.hops} here"
    if not 0 <= step.index < len(fabric.links):
        return f"names link {step.index}, which does not exist"
    end = fabric.links[step.index].dst
    return None if end == step.pe else f"says PE {step.pe}; link {step.index} ends at {end}"


def _move_fault(fabric: Fabric, start_pe: int, before: Step | None, step: Step) -> str | None:
    """A step that the word cannot make from the PE where it is readable."""
    leaves = fabric.links[step.index].src if step.kind == "link" else step.pe
    found_on = (start_pe,) if before is None else _readers(fabric, before)
    if leaves not in found_on:
        where = f"the word is on PE {found_on[0]}"
        if step.kind == "link":
            return f"takes link {step.index}, which leaves PE {leaves}; {where}"
        kind = "a register" if step.kind == "reg" else "the output register"
        return f"writes {kind} of PE {step.pe}; {where}"
    if before is None or _stays(fabric, before, step):
        return None
    if _is_moved(fabric, step):
        return None if fabric.routing.moves else f"needs the FU of PE {step.pe} to move the word"
    if before.kind == "out" and not _crossbar_takes_outputs(fabric):
        return f"takes the word from the output register of PE {before.pe}, which only an FU reads"
    return None


def _stays(fabric: Fabric, before: Step, step: Step) -> bool:
    """The word is where it was a cycle ago, and nothing has to be done for it."""
    if (before.kind, before.pe, before.index) != (step.kind, step.pe, step.index):
        return False
    return step.kind == "reg" or (step.kind == "out" and fabric.routing.holds)


def _is_moved(fabric: Fabric, step: Step) -> bool:
    """The word got there as the result of a move, when it is not its producer's result any more."""
    return step.kind == "out" or (step.kind == "reg" and fabric.pes[step.pe].written_by_fu)


def _crossbar_takes_outputs(fabric: Fabric) -> bool:
    routing = fabric.routing
    return routing.holds or routing.shared or routing.moves


def _source(step: Step) -> _Resource:
    return ("link", 0, step.index) if step.kind == "link" else (step.kind, step.pe, step.index)


@dataclass
class _Traffic:
    """All well-formed routes together: who is where in which slot, and the ports in use."""

    case: Case
    words: dict[tuple[_Resource, int], dict[_Word, set[_Resource]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )
    reads: dict[tuple[int, int], dict[int, set[int]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )
    writes: dict[tuple[int, int], dict[int, set[int]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(set))
    )

    moves: dict[tuple[int, int], set[int]] = field(default_factory=lambda: defaultdict(set))

    def add(self, value: int, route: tuple[Step, ...]) -> None:
        """Enter the places of one route, with the place that drives each."""
        fabric = self.case.fabric
        before: Step | None = None
        for step in route:
            came_from = _RES if before is None else _source(before)
            if before is not None and _passes_on(before, step):
                came_from = ("wire", *came_from[1:])
            self._enter(self._resource(step), value, step.time, came_from)
            if before is None or not _stays(fabric, before, step):
                self._read(value, before)
                self._write(value, step)
                if before is not None and _is_moved(fabric, step):
                    self._move(value, step, came_from)
            before = step
        self._read(value, before)

    def add_results(self) -> None:
        """Every operation that completes takes its output register, even if its word is unused.

        Where output registers do not hold and nothing else enters them, that is the rule of one
        completion a slot.
        """
        if not _crossbar_takes_outputs(self.case.fabric):
            return
        for node, place in self.case.placed():
            if node.op is not Opcode.LIVE_OUT:
                self._enter(("out", place.pe, 0), node.id, self.case.ready(node.id), _RES)

    def _enter(self, resource: _Resource, value: int, time: int, came_from: _Resource) -> None:
        self.words[resource, self.case.slot(time)][value, time].add(came_from)

    def _resource(self, step: Step) -> _Resource:
        """What the word takes. A rotating file has turned by one register in each II cycles."""
        if step.kind != "reg" or not self.case.fabric.pes[step.pe].rotating:
            return _source(step)
        turned = step.index - step.time // self.case.ii
        return "reg", step.pe, turned % self.case.fabric.pes[step.pe].registers

    def _move(self, value: int, step: Step, came_from: _Resource) -> None:
        """A move passes through the output register, wherever its result goes besides."""
        self.moves[step.pe, step.time - 1].add(value)
        self._enter(("out", step.pe, 0), value, step.time, came_from)

    def _read(self, value: int, step: Step | None) -> None:
        if step is not None and step.kind == "reg":
            register = self._resource(step)[2]
            self.reads[step.pe, self.case.slot(step.time)][register].add(value)

    def _write(self, value: int, step: Step) -> None:
        if step.kind == "reg":
            register = self._resource(step)[2]
            self.writes[step.pe, self.case.slot(step.time - 1)][register].add(value)

    def conflicts(self) -> Iterator[Violation]:
        """Resources that two words need at once, two drivers of one word, and too few ports."""
        yield from self._clashes()
        yield from self._ports("read", self.reads, [p.read_ports for p in self.case.fabric.pes])
        yield from self._ports("write", self.writes, [p.write_ports for p in self.case.fabric.pes])

    def _clashes(self) -> Iterator[Violation]:
        for (resource, slot), words in self.words.items():
            if len(words) > 1:
                nodes = tuple(sorted({node for node, _ in words}))
                kind = {"link": "link", "reg": "register", "out": "output"}[resource[0]]
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
                    f"PE {pe} has {ports[pe]} {verb} ports; registers {listed(sorted(registers))} "
                    f"are to be {'read' if verb == 'read' else 'written'} in slot {slot}"
                )
                nodes = sorted(set().union(*registers.values()))
                yield Violation(f"{verb}_ports", text, tuple(nodes))


def _name(resource: _Resource) -> str:
    kind, pe, index = resource
    return {
        "res": "the FU's result",
        "out": f"the output register of PE {pe}",
        "wire": f"link {index} in the same cycle",
        "link": f"link {index}",
    }.get(kind, f"register {index} of PE {pe}")
