"""An exhaustive modulo mapper for tiny graphs on fabrics with any option of docs/machine.md.

Times and places are enumerated as in `brute_force`, every route step by step; what a step needs is
a claim on a resource of limited capacity, and two claims are one if they say the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Mapping as ReadOnly
from typing import NamedTuple

from brute_force import _Placer

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Step


class Claim(NamedTuple):
    """Someone's use of a resource in a slot; `capacity` different ones fit."""

    resource: tuple[object, ...]
    slot: int
    capacity: int
    claimant: tuple[object, ...]


def minimum_ii(
    dfg: DFG, fabric: Fabric, *, allowed: ReadOnly[int, frozenset[int]] | None = None
) -> tuple[int, Mapping] | None:
    """The least II that the contexts permit, with a mapping; None if there is none."""
    for ii in range(1, fabric.controller.contexts + 1):
        found = _AnyPlacer(dfg, fabric, ii, allowed or {}).search()
        if found is not None:
            return ii, found
    return None


class _AnyPlacer(_Placer):
    def _far_enough(self, edge: Edge) -> bool:
        if edge.kind is not EdgeKind.DATA:
            return super()._far_enough(edge)
        (_, src), (_, dst) = self.start[edge.src], self.start[edge.dst]
        return dst + self.ii * edge.distance >= src + self._latency(edge.src)

    def _collide(self, a: Node, pe_a: int, time_a: int, b: Node, pe_b: int, time_b: int) -> bool:
        if super()._collide(a, pe_a, time_a, b, pe_b, time_b):
            return True
        if pe_a != pe_b or Opcode.LIVE_OUT in (a.op, b.op):
            return False
        busy_a = {(time_a + k) % self.ii for k in range(self.fabric.occupancy(a))}
        busy_b = {(time_b + k) % self.ii for k in range(self.fabric.occupancy(b))}
        return bool(busy_a & busy_b)

    def _is_routable(self) -> bool:
        if any(self.fabric.occupancy(self.dfg.by_id[n]) > self.ii for n in self.start):
            return False
        board = _Board(self.fabric, self.ii)
        for node_id, (pe, time) in self.start.items():
            node = self.dfg.by_id[node_id]
            if node.op is not Opcode.LIVE_OUT:
                board.operation(node, pe, time, time + self._latency(node_id))
        pending = []
        for index, edge in enumerate(self.dfg.edges):
            if edge.kind is EdgeKind.DATA and self._both_placed(edge):
                (pe_src, time_src), (pe_dst, time_dst) = self.start[edge.src], self.start[edge.dst]
                ready = time_src + self._latency(edge.src)
                read = time_dst + self.ii * edge.distance
                pending.append((read - ready, edge.src, index, pe_src, ready, pe_dst, read))
        if not board.route(sorted(pending)):
            return False
        self.routes = board.routes
        return True


class _Board:
    def __init__(self, fabric: Fabric, ii: int) -> None:
        self.fabric, self.ii = fabric, ii
        self.claims: dict[tuple[object, ...], list[tuple[object, ...]]] = {}
        self.routes: dict[int, tuple[Step, ...]] = {}
        self.touched: dict[tuple[int, int], int] = {}
        self.open = any((fabric.routing.holds, fabric.routing.shared, fabric.routing.moves))

    def operation(self, node: Node, pe: int, time: int, ready: int) -> None:
        """Claims of an operation itself; the placer has seen to it that they do not collide."""
        wanted = [
            self._on("fu", pe, time + k, ("op", node.id))
            for k in range(self.fabric.occupancy(node))
        ]
        if self.open:
            wanted.append(self._on("out", pe, ready, (node.id, ready, "result")))
        assert self._take(wanted)

    def _on(
        self, kind: str, index: object, time: int, claimant: tuple[object, ...], capacity: int = 1
    ) -> Claim:
        return Claim((kind, index), time % self.ii, capacity, claimant)

    def _take(self, wanted: list[Claim]) -> bool:
        done = []
        for claim in wanted:
            held = self.claims.setdefault((claim.resource, claim.slot), [])
            held.append(claim.claimant)
            done.append(claim)
            if len(set(held)) > claim.capacity:
                self._give(done)
                return False
        return True

    def _give(self, wanted: list[Claim]) -> None:
        for claim in wanted:
            self.claims[claim.resource, claim.slot].remove(claim.claimant)

    def route(self, pending: list[tuple[int, ...]]) -> bool:
        """Whether all words find ways together; `routes` then says which."""
        if not pending:
            return True
        _, value, index, pe, ready, to_pe, read = pending[0]
        if (pe, ready) == (to_pe, read):
            self.routes[index] = ()
            if self.route(pending[1:]):
                return True
        for path in self._paths(value, pe, ready, to_pe, read, ()):
            self.routes[index] = path
            if self.route(pending[1:]):
                return True
        return False

    def _paths(
        self, value: int, pe: int, ready: int, to_pe: int, read: int, path: tuple[Step, ...]
    ) -> Iterator[tuple[Step, ...]]:
        """All ways on; while one is handed out, what it needs is claimed."""
        if path and path[-1].time == read and to_pe in self._readers(path[-1]):
            last = self._reading(path[-1])
            if self._take(last):
                yield path
                self._give(last)
        for step in self._next(pe, ready, path):
            if step.time > read:
                continue
            wanted = self._needs(value, path, step)
            if wanted is None or not self._take(wanted):
                continue
            yield from self._paths(value, pe, ready, to_pe, read, (*path, step))
            self._give(wanted)

    def _readers(self, step: Step) -> list[int]:
        found = [step.pe]
        if step.kind == "out" and self.fabric.routing.shared:
            found += [k.dst for k in self.fabric.links if k.src == step.pe]
        return found

    def _next(self, pe: int, ready: int, path: tuple[Step, ...]) -> Iterator[Step]:
        last = path[-1] if path else None
        hops = self.fabric.routing.hops
        if last is not None and last.kind == "link":
            chain = sum(s.kind == "link" and s.time == last.time for s in path)
            used = {s.index for s in path if s.kind == "link" and s.time == last.time}
            for link in self.fabric.links:
                if chain < hops and link.src == last.pe and link.id not in used:
                    yield Step("link", link.dst, link.id, last.time)
        time = ready if last is None else last.time + 1
        for at in [pe] if last is None else self._readers(last):
            for link in self.fabric.links:
                if hops and link.src == at:
                    yield Step("link", link.dst, link.id, time)
            for register in range(self.fabric.pes[at].registers):
                yield Step("reg", at, register, time)
            yield Step("out", at, 0, time)

    def _reading(self, step: Step) -> list[Claim]:
        if step.kind != "reg":
            return []
        ports = self.fabric.pes[step.pe].read_ports
        place = self._register(step)
        return [self._on("reads", step.pe, step.time, place, ports)]

    def _register(self, step: Step) -> tuple[object, ...]:
        pe = self.fabric.pes[step.pe]
        if not pe.rotating:
            return (step.pe, step.index)
        return (step.pe, (step.index - step.time // self.ii) % pe.registers)

    def _needs(self, value: int, path: tuple[Step, ...], step: Step) -> list[Claim] | None:
        """The claims of one more step; None if the fabric has no such way."""
        last = path[-1] if path else None
        came = "result" if last is None else (last.kind, last.pe, last.index, last.time)
        word = (value, step.time, came)
        place = self._place(step, word)
        if last is None and step.kind == "out":
            return [place] if self.open else []
        if last is not None and self._keeps(last, step):
            return [place]
        wanted = [place]
        if step.kind == "reg":
            ports = self.fabric.pes[step.pe].write_ports
            wanted.append(self._on("writes", step.pe, step.time - 1, self._register(step), ports))
        if last is None:
            return wanted
        if last.time < step.time:
            wanted += self._reading(last)
        if step.kind == "out" or (step.kind == "reg" and self.fabric.pes[step.pe].written_by_fu):
            wanted.append(self._on("fu", step.pe, step.time - 1, ("move", *word)))
            wanted.append(self._on("out", step.pe, step.time, word))
            return wanted if self.fabric.routing.moves else None
        return None if last.kind == "out" and not self.open else wanted

    def _place(self, step: Step, word: tuple[object, ...]) -> Claim:
        where = {"link": step.index, "reg": self._register(step), "out": step.pe}
        return self._on(step.kind, where[step.kind], step.time, word)

    def _keeps(self, last: Step, step: Step) -> bool:
        same = (last.kind, last.pe, last.index) == (step.kind, step.pe, step.index)
        held = step.kind == "reg" or (step.kind == "out" and self.fabric.routing.holds)
        return same and held
