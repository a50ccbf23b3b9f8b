"""What a mapped region takes of the fabric in cycles of another one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Step
from vividc.mapper.problem import ConstantKey, MapProblem, Taken

Cycles = Callable[[int], Iterable[int]]
"""Cycles in which there is what comes at a time of each iteration."""


def taken_of(dfg: DFG, fabric: Fabric, mapping: Mapping, cycles: Cycles) -> Taken:
    """All that is taken in these cycles."""
    return _Taken(dfg, fabric, mapping, cycles).made()


class Use(NamedTuple):
    """An entry of a PE's constant store that is read at a time of each iteration, or written."""

    pe: int
    key: ConstantKey
    time: int
    writes: bool


def uses_of(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Iterator[Use]:
    """Of constant stores."""
    problem = MapProblem(dfg, fabric)
    for node in dfg.placed:
        place = mapping.places[node.id]
        for key in problem.constants_of(node):
            writes = node.op is Opcode.LIVE_OUT and key == ("live_in", node.name)
            yield Use(place.pe, key, place.time, writes)


class _Taken:
    def __init__(self, dfg: DFG, fabric: Fabric, mapping: Mapping, cycles: Cycles) -> None:
        self._dfg, self._fabric, self._mapping, self._cycles = dfg, fabric, mapping, cycles
        self._words: set[tuple[str, int, int, int]] = set()
        self._written: set[tuple[int, int, int]] = set()
        self._read: set[tuple[int, int, int]] = set()

    def made(self) -> Taken:
        """All of it."""
        places, fabric, cycles = self._mapping.places, self._fabric, self._cycles
        issued, completed, shown = set(), set(), set()
        accesses = set()
        for node in self._dfg.placed:
            place = places[node.id]
            if node.op is Opcode.LIVE_OUT:
                shown |= {(place.pe, cycle) for cycle in cycles(place.time)}
                continue
            for busy in range(fabric.occupancy(node)):
                issued |= {(place.pe, cycle) for cycle in cycles(place.time + busy)}
            end = place.time + fabric.latency(node)
            completed |= {(place.pe, cycle) for cycle in cycles(end)}
            if node.is_memory:
                is_store = node.op is Opcode.STORE
                accesses |= {(cycle, node.name, is_store) for cycle in cycles(place.time)}
        for index, route in self._mapping.routes.items():
            self._move(route, self._dfg.edges[index].distance)
        return Taken(
            frozenset(issued),
            frozenset(completed),
            frozenset(shown),
            frozenset(self._words),
            frozenset(self._written),
            frozenset(self._read),
            frozenset(accesses),
        )

    def _move(self, route: tuple[Step, ...], distance: int) -> None:
        """A first iteration has the port for a word that it does not carry, too."""
        cycles = self._cycles
        before: Step | None = None
        for step in route:
            words = ((step.kind, step.pe, step.index, cycle) for cycle in cycles(step.time))
            self._words.update(words)
            held = None if before is None else (before.kind, before.index)
            stays = held == ("reg", step.index) and step.kind == "reg"
            for cycle in () if stays else cycles(step.time - 1):
                if step.kind == "reg":
                    self._written.add((step.pe, step.index, cycle))
                if before is not None and before.kind == "reg":
                    self._read.add((before.pe, before.index, cycle))
            before = step
        if before is not None and before.kind == "reg":
            for back in range(distance + 1):
                for cycle in cycles(before.time - back * self._mapping.ii):
                    self._read.add((before.pe, before.index, cycle))
