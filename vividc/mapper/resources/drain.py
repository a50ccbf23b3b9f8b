"""What is left of a loop's last iterations when the straight region behind it begins."""

from __future__ import annotations

from collections.abc import Iterator

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Step
from vividc.mapper.problem import ConstantKey, Drain, MapProblem


def drain_of(dfg: DFG, fabric: Fabric, mapping: Mapping, begin: int, cycles: int) -> Drain:
    """The drain of a counted loop without an exit.

    Parameters
    ----------
    begin
        Cycle of the last iteration in which the region behind the loop begins, at least the II.
    cycles
        Of that region until nothing of the loop is left: the loop's span is `begin + cycles`.
    """
    return _Drain(dfg, fabric, mapping, begin, cycles).made()


_Entries = dict[tuple[int, ConstantKey], int]


class _Drain:
    def __init__(self, dfg: DFG, fabric: Fabric, mapping: Mapping, begin: int, cycles: int) -> None:
        self._dfg, self._fabric, self._mapping = dfg, fabric, mapping
        self._begin, self._cycles = begin, cycles
        self._words: set[tuple[str, int, int, int]] = set()
        self._written: set[tuple[int, int, int]] = set()
        self._read: set[tuple[int, int, int]] = set()

    def made(self) -> Drain:
        """All of it."""
        places, fabric = self._mapping.places, self._fabric
        issued, completed, shown = set(), set(), set()
        accesses = set()
        for node in self._dfg.placed:
            place = places[node.id]
            if node.op is Opcode.LIVE_OUT:
                shown |= {(place.pe, cycle) for cycle in self._after(place.time)}
                continue
            for busy in range(fabric.occupancy(node)):
                issued |= {(place.pe, cycle) for cycle in self._after(place.time + busy)}
            completed |= {
                (place.pe, cycle) for cycle in self._after(place.time + fabric.latency(node))
            }
            if node.is_memory:
                is_store = node.op is Opcode.STORE
                accesses |= {(cycle, node.name, is_store) for cycle in self._after(place.time)}
        for route in self._mapping.routes.values():
            self._move(route)
        return Drain(
            self._cycles,
            frozenset(issued),
            frozenset(completed),
            frozenset(shown),
            frozenset(self._words),
            frozenset(self._written),
            frozenset(self._read),
            frozenset(accesses),
            *(frozenset((*at, cycle) for at, cycle in some.items()) for some in self._entries()),
        )

    def _after(self, time: int) -> Iterator[int]:
        """Cycles of the region in which what comes at a time of each iteration is left."""
        yield from range(time - self._begin, -1, -self._mapping.ii)

    def _move(self, route: tuple[Step, ...]) -> None:
        before: Step | None = None
        for step in route:
            for cycle in self._after(step.time):
                if cycle <= self._cycles:
                    self._words.add((step.kind, step.pe, step.index, cycle))
            held = None if before is None else (before.kind, before.index)
            stays = held == ("reg", step.index) and step.kind == "reg"
            for cycle in () if stays else self._after(step.time - 1):
                if step.kind == "reg":
                    self._written.add((step.pe, step.index, cycle))
                if before is not None and before.kind == "reg":
                    self._read.add((before.pe, before.index, cycle))
            before = step
        if before is not None and before.kind == "reg":
            self._read |= {(before.pe, before.index, cycle) for cycle in self._after(before.time)}

    def _entries(self) -> tuple[_Entries, _Entries]:
        """The last cycle in which each entry is read, and the first in which it is as written."""
        problem = MapProblem(self._dfg, self._fabric)
        read: _Entries = {}
        written: _Entries = {}
        for node in self._dfg.placed:
            place = self._mapping.places[node.id]
            cycle = place.time - self._begin
            for entry in problem.constants_of(node) if cycle >= 0 else ():
                key = place.pe, entry
                if node.op is Opcode.LIVE_OUT and entry == ("live_in", node.name):
                    written[key] = max(written.get(key, 0), cycle + 1)
                else:
                    read[key] = max(read.get(key, 0), cycle)
        return read, written
