"""The verifier on routes: each by itself, then all together on links, registers and ports."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Edge
from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Step
from vividc.mapper.verify_case import Case, Violation, listed

_Resource = tuple[str, int, int]
"""("link", 0, link) or ("reg", pe, register)."""

_Word = tuple[int, int]
"""(producer, cycle of the producer's iteration)."""

_RES: _Resource = ("res", 0, 0)
"""The place a route starts from: the result in the cycle in which the operation completes."""


def route_violations(case: Case) -> Iterator[Violation]:
    """Faulty routes, and sound ones that need one resource at once."""
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
                    f"PE {pe} has {ports[pe]} {verb} ports; registers {listed(sorted(registers))} "
                    f"are to be {'read' if verb == 'read' else 'written'} in slot {slot}"
                )
                nodes = sorted(set().union(*registers.values()))
                yield Violation(f"{verb}_ports", text, tuple(nodes))


def _name(resource: _Resource) -> str:
    kind, pe, index = resource
    if kind == "res":
        return "the FU's result"
    return f"link {index}" if kind == "link" else f"register {index} of PE {pe}"
