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
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Step

Resource = tuple[str, int, int]
"""("link" or "wire", 0, link), ("reg", PE, name), ("out" or "result", PE, 0)."""
Tag = tuple[int, int]


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
        self.moves: dict[tuple[int, int], Resource] = {}
        self.rewritten: set[tuple[int, str]] = set()

    def encode(self) -> None:
        """One source for each (link or register, slot) and for each operand."""
        for index, edge in self.dfg.routed_edges():
            source = self.mapping.places[edge.src]
            at: Resource = ("result", source.pe, 0)
            before: Step | None = None
            for step in self.mapping.routes[index]:
                self._step(edge, before, step, at)
                at, before = self._resource(step, step.time), step
            reader = self.mapping.places[edge.dst].pe
            if before is None:
                at = ("out", source.pe, 0)
            _need(reader in self._readers(at), "the operand is on another PE")
            self.operand[index] = at

    def _step(self, edge: Edge, before: Step | None, step: Step, at: Resource) -> None:
        """What drives the place of one step, and by whose means."""
        routing = self.fabric.routing
        here = self._resource(step, step.time)
        if (
            before is not None
            and (before.kind, before.pe, before.index) == (step.kind, step.pe, step.index)
            and step.time == before.time + 1
            and (step.kind == "reg" or (step.kind == "out" and routing.holds))
        ):
            return
        if before is not None and step.time == before.time:
            _need(before.kind == step.kind == "link", "two places in one cycle")
            at = ("wire", 0, before.index)
        elif before is not None:
            _need(step.time == before.time + 1, "a cycle is missing")
        _need(self._reads_from(here) in self._readers(at), "a wire is missing")
        fresh = before is None
        if fresh and step.kind == "out":
            ready = self.mapping.places[edge.src].time + self._latency(edge.src)
            _need(step.time == ready, "the result is not there yet")
            return
        slot = (step.time - 1) % self.ii
        fu_writes = step.kind == "reg" and self.fabric.pes[step.pe].written_by_fu
        if not fresh and (step.kind == "out" or fu_writes):
            _need(routing.moves, "nothing moves words here")
            known = self.moves.setdefault((step.pe, slot), at)
            _need(known == at, "two moves at once")
            at = ("result", step.pe, 0)
        elif at[0] == "out":
            _need(routing.holds or routing.shared or routing.moves, "only an FU reads outputs")
        if step.kind != "out":
            self._drive(self._resource(step, step.time - 1), at, step.time - 1)

    def _readers(self, at: Resource) -> set[int]:
        kind, pe, index = at
        if kind in ("link", "wire"):
            return {self.fabric.links[index].dst}
        shared = kind == "out" and self.fabric.routing.shared
        return {pe} | {k.dst for k in self.fabric.links if k.src == pe and shared}

    def _drive(self, here: Resource, at: Resource, time: int) -> None:
        slot = time % self.ii
        known = self.driver.setdefault((here, slot), at)
        _need(known == at, f"two sources for {here} in slot {slot}")

    def _resource(self, step: Step, cycle: int) -> Resource:
        """The place of a step, a register under its name in that cycle."""
        if step.kind == "link":
            _need(self.fabric.routing.hops > 0, "links carry nothing")
            _need(0 <= step.index < len(self.fabric.links), "no such link")
            _need(step.pe == self.fabric.links[step.index].dst, "the link does not end there")
            return ("link", 0, step.index)
        _need(0 <= step.pe < len(self.fabric.pes), "no such PE")
        if step.kind == "out":
            _need(step.index == 0, "no such output register")
            return ("out", step.pe, 0)
        registers = self.fabric.pes[step.pe].registers
        _need(0 <= step.index < registers, "no such register")
        turned = cycle // self.ii if self.fabric.pes[step.pe].rotating else 0
        return ("reg", step.pe, (step.index - turned) % registers)

    def _reads_from(self, resource: Resource) -> int:
        return self.fabric.links[resource[2]].src if resource[0] == "link" else resource[1]

    def count_ports(self) -> None:
        """Registers selected for reading and for writing in one slot."""
        reads: set[tuple[int, int, int]] = set()
        writes: Counter[tuple[int, int]] = Counter()
        for (here, slot), at in self.driver.items():
            if at[0] == "reg":
                reads.add((at[1], slot, at[2]))
            if here[0] == "reg":
                writes[here[1], slot] += 1
        for (_, slot), at in self.moves.items():
            if at[0] == "reg":
                reads.add((at[1], slot, at[2]))
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
        self._check_units()
        for time in range(max(issues, default=0) + 1):
            self._issue(issues.get(time, []), time)
            self._clock(time, completions)

    def _check_units(self) -> None:
        """An FU starts one thing at a time, and one that is busy nothing."""
        busy = Counter(self.moves.keys())
        for node in self.dfg.placed:
            place = self.mapping.places[node.id]
            for cycle in range(self.fabric.occupancy(node) if node.uses_fu else 0):
                busy[place.pe, (place.time + cycle) % self.ii] += 1
        _need(max(busy.values(), default=0) <= 1, "an FU is busy")

    def _latency(self, node: int) -> int:
        return self.fabric.latencies[self.dfg.by_id[node].latency_class]

    def _issue(self, tags: list[Tag], time: int) -> None:
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
                    self._check_operand(edge, source, iteration - edge.distance, time)

    def _check_constants(self, node: int) -> None:
        """A constant-store entry holds the word from before the region until a live-out."""
        pe = self.mapping.places[node].pe
        operands = [edge for edge in self.dfg.in_edges[node] if edge.kind is EdgeKind.DATA]
        for source in (end for edge in operands for end in (edge.src, edge.init)):
            if source is not None and self.dfg.by_id[source].op is Opcode.LIVE_IN:
                name = self.dfg.by_id[source].name
                _need((pe, name) not in self.rewritten, f"{name} is read after it was written")

    def _check_operand(self, edge: Edge, source: Resource, iteration: int, time: int) -> None:
        word = self.state.get(self._physical(source, time))
        _need(word == (edge.src, iteration), f"{edge.src} -> {edge.dst} finds {word}")

    def _physical(self, place: Resource, time: int) -> Resource:
        """The register that a name means in a cycle."""
        kind, pe, index = place
        if kind != "reg" or not self.fabric.pes[pe].rotating:
            return place
        return (kind, pe, (index + time // self.ii) % self.fabric.pes[pe].registers)

    def _clock(self, time: int, completions: dict[tuple[int, int], Tag]) -> None:
        slot = time % self.ii
        results: dict[int, Tag | None] = {}
        for pe in self.fabric.pes:
            if (pe.id, time) in completions:
                results[pe.id] = completions[pe.id, time]
        for (pe_id, when), at in self.moves.items():
            if when == slot:
                _need(pe_id not in results, "a move and an operation complete at once")
                results[pe_id] = self.state.get(self._physical(at, time))
        after = {place: word for place, word in self.state.items() if place[0] != "link"}
        if not self.fabric.routing.holds:
            after = {place: word for place, word in after.items() if place[0] == "reg"}
        for (here, when), at in self.driver.items():
            if when == slot and at != here:
                word = self._carried(at, time, results, 1)
                after[self._physical(here, time)] = word
        after |= {("out", pe_id, 0): word for pe_id, word in results.items()}
        self.state = after

    def _carried(
        self, at: Resource, time: int, results: dict[int, Tag | None], hops: int
    ) -> Tag | None:
        """What a source delivers in a cycle; links of the cycle pass on what drives them."""
        if at[0] == "result":
            return results.get(at[1])
        if at[0] != "wire":
            return self.state.get(self._physical(at, time))
        _need(hops < self.fabric.routing.hops, "too many links in a cycle")
        driver = self.driver.get((("link", 0, at[2]), time % self.ii))
        return None if driver is None else self._carried(driver, time, results, hops + 1)

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
