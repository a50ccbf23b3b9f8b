"""A tiny machine that runs a mapping with tagged words: the second opinion on the verifier.

The mapping is turned into what a configuration word holds (a source for each link and register in
each slot, a source for each operand), as docs/machine.md describes it, and iterations are run
through it. A word is the tag (node, iteration) of the operation that made it. The mapping is right
if every operand finds its tag. Nothing is known here about words sharing places; wrong sharing
shows as wrong tags.
"""

from __future__ import annotations

from collections import Counter

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind
from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Step

Resource = tuple[str, int, int]
Tag = tuple[int, int]
RESULT: Resource = ("result", 0, 0)
OUT: Resource = ("out", 0, 0)


class Broken(Exception):
    """The mapping cannot be encoded, or a run of it goes wrong."""


def replay(dfg: DFG, fabric: Fabric, mapping: Mapping, iterations: int) -> None:
    """Encode and run; raises `Broken` with the first thing that goes wrong."""
    _static_limits(dfg, fabric, mapping)
    machine = _Machine(dfg, fabric, mapping)
    machine.encode()
    machine.count_ports()
    machine.run(iterations)


def _need(condition: bool, what: str) -> None:
    if not condition:
        raise Broken(what)


def _static_limits(dfg: DFG, fabric: Fabric, mapping: Mapping) -> None:
    wanted = {node.id for node in dfg.placed}
    _need(set(mapping.places) == wanted, "the placed nodes are not those of the graph")
    _need(1 <= mapping.ii <= fabric.controller.contexts, "the contexts do not suffice")
    _need(set(mapping.routes) == {i for i, _ in dfg.routed_edges()}, "routes do not fit the edges")
    stores: dict[int, set[tuple[str, object]]] = {pe.id: set() for pe in fabric.pes}
    for node in dfg.placed:
        place = mapping.places[node.id]
        _need(0 <= place.pe < len(fabric.pes), "no such PE")
        _need(0 <= place.time < mapping.ii * fabric.controller.max_stages, "no such stage")
        is_fu = node.op is not Opcode.LIVE_OUT
        _need(not is_fu or node.latency_class in fabric.pes[place.pe].classes, "wrong FU")
        store = stores[place.pe]
        if not is_fu:
            store.add(("variable", node.name))
        for edge in dfg.edges:
            if edge.dst == node.id and edge.kind is EdgeKind.DATA:
                for source in (dfg.by_id[i] for i in (edge.src, edge.init) if i is not None):
                    if source.op is Opcode.CONST:
                        store.add(("word", source.const))
                    elif source.op is Opcode.LIVE_IN:
                        store.add(("variable", source.name))
    for pe in fabric.pes:
        _need(len(stores[pe.id]) <= pe.constants, "the constant store overflows")


class _Machine:
    def __init__(self, dfg: DFG, fabric: Fabric, mapping: Mapping) -> None:
        self.dfg, self.fabric, self.mapping, self.ii = dfg, fabric, mapping, mapping.ii
        self.driver: dict[tuple[Resource, int], Resource] = {}
        self.operand: dict[int, Resource] = {}
        self.state: dict[Resource, Tag | None] = {}
        self.out: dict[int, Tag | None] = {}
        self.rewritten: set[tuple[int, str]] = set()

    def encode(self) -> None:
        """One source for each (link or register, slot) and for each operand."""
        for index, edge in self.dfg.routed_edges():
            at: Resource = RESULT
            pe = self.mapping.places[edge.src].pe
            for step in self.mapping.routes[index]:
                here = self._resource(step)
                _need(self._reads_from(here) == pe, "a wire is missing")
                self._drive(here, at, step.time - 1)
                at, pe = here, self._ends_on(here)
            _need(pe == self.mapping.places[edge.dst].pe, "the operand is on another PE")
            self.operand[index] = OUT if at == RESULT else at

    def _drive(self, here: Resource, at: Resource, time: int) -> None:
        slot = time % self.ii
        known = self.driver.setdefault((here, slot), at)
        _need(known == at, f"two sources for {here} in slot {slot}")

    def _resource(self, step: Step) -> Resource:
        if step.kind == "link":
            _need(0 <= step.index < len(self.fabric.links), "no such link")
            _need(step.pe == self.fabric.links[step.index].dst, "the link does not end there")
            return ("link", 0, step.index)
        _need(step.kind == "reg" and 0 <= step.pe < len(self.fabric.pes), "no such register file")
        _need(0 <= step.index < self.fabric.pes[step.pe].registers, "no such register")
        return ("reg", step.pe, step.index)

    def _reads_from(self, resource: Resource) -> int:
        return resource[1] if resource[0] == "reg" else self.fabric.links[resource[2]].src

    def _ends_on(self, resource: Resource) -> int:
        return resource[1] if resource[0] == "reg" else self.fabric.links[resource[2]].dst

    def count_ports(self) -> None:
        """Registers selected for reading and for writing in one slot."""
        reads: set[tuple[int, int, int]] = set()
        writes: Counter[tuple[int, int]] = Counter()
        for (here, slot), at in self.driver.items():
            if at[0] == "reg" and at != here:
                reads.add((at[1], slot, at[2]))
            if here[0] == "reg" and at != here:
                writes[here[1], slot] += 1
        for index, at in self.operand.items():
            if at[0] == "reg":
                slot = self.mapping.places[self.dfg.edges[index].dst].time % self.ii
                reads.add((at[1], slot, at[2]))
        for (pe, _), count in Counter((pe, slot) for pe, slot, _ in reads).items():
            _need(count <= self.fabric.pes[pe].read_ports, "too few read ports")
        for (pe, _), count in writes.items():
            _need(count <= self.fabric.pes[pe].write_ports, "too few write ports")

    def run(self, iterations: int) -> None:
        """Clock the machine until the last iteration is done."""
        issues: dict[int, list[Tag]] = {}
        completions: dict[tuple[int, int], Tag] = {}
        for node in self.dfg.placed:
            for iteration in range(iterations):
                time = iteration * self.ii + self.mapping.places[node.id].time
                issues.setdefault(time, []).append((node.id, iteration))
                if node.uses_fu:
                    end = (self.mapping.places[node.id].pe, time + self._latency(node.id) - 1)
                    _need(end not in completions, "two operations complete at once")
                    completions[end] = (node.id, iteration)
        self._check_effects(iterations)
        for time in range(max(issues, default=0) + 1):
            self._issue(issues.get(time, []))
            self._clock(time, completions)

    def _latency(self, node: int) -> int:
        return self.fabric.latencies[self.dfg.by_id[node].latency_class]

    def _issue(self, tags: list[Tag]) -> None:
        units = Counter(
            (self.mapping.places[node].pe, self.dfg.by_id[node].uses_fu) for node, _ in tags
        )
        _need(max(units.values(), default=0) <= 1, "two issue on one PE")
        for node, _ in tags:
            self._check_constants(node)
        for node, iteration in tags:
            if self.dfg.by_id[node].op is Opcode.LIVE_OUT:
                self.rewritten.add((self.mapping.places[node].pe, self.dfg.by_id[node].name))
            for index, source in self.operand.items():
                edge = self.dfg.edges[index]
                if edge.dst == node and iteration >= edge.distance:
                    self._check_operand(edge, source, iteration - edge.distance)

    def _check_constants(self, node: int) -> None:
        """A constant-store entry holds the word from before the region until a live-out."""
        pe = self.mapping.places[node].pe
        operands = [edge for edge in self.dfg.in_edges[node] if edge.kind is EdgeKind.DATA]
        for source in (end for edge in operands for end in (edge.src, edge.init)):
            if source is not None and self.dfg.by_id[source].op is Opcode.LIVE_IN:
                name = self.dfg.by_id[source].name
                _need((pe, name) not in self.rewritten, f"{name} is read after it was written")

    def _check_operand(self, edge: Edge, source: Resource, iteration: int) -> None:
        pe = self.mapping.places[edge.dst].pe
        word = self.out.get(pe) if source == OUT else self.state.get(source)
        _need(word == (edge.src, iteration), f"{edge.src} -> {edge.dst} finds {word}")

    def _clock(self, time: int, completions: dict[tuple[int, int], Tag]) -> None:
        after = {place: word for place, word in self.state.items() if place[0] == "reg"}
        for (here, slot), at in self.driver.items():
            if slot != time % self.ii or at == here:
                continue
            if at == RESULT:
                after[here] = completions.get((self._reads_from(here), time))
            else:
                after[here] = self.state.get(at)
        self.state = after
        self.out = {pe.id: completions.get((pe.id, time)) for pe in self.fabric.pes}

    def _check_effects(self, iterations: int) -> None:
        """Separations of ORDER and CONTROL edges, and one control result a cycle."""
        results: Counter[int] = Counter()
        for node in self.dfg.placed:
            if node.control is not None:
                for iteration in range(iterations):
                    start = iteration * self.ii + self.mapping.places[node.id].time
                    results[start + self._latency(node.id)] += 1
        _need(max(results.values(), default=0) <= 1, "two control results at once")
        for edge in self.dfg.edges:
            if edge.kind is EdgeKind.DATA:
                continue
            gap = 1
            if edge.kind is EdgeKind.CONTROL:
                gap = self._latency(edge.src) + self.fabric.controller.control_latency
            first = self.mapping.places[edge.src].time
            then = self.mapping.places[edge.dst].time + edge.distance * self.ii
            _need(then >= first + gap, "an effect comes too early")
