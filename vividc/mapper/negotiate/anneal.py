"""Simulated annealing of places and times (Kirkpatrick et al. 1983; for CGRAs Mei et al. 2002).

The cost of a schedule is what it breaks (two operations on an FU, a word that cannot be there in
time) and, far less, how far and how long words travel. Links and registers are not modelled: they
are the router's part.
"""

from __future__ import annotations

import math
import random
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.mapper.deadline import Deadline
from vividc.mapper.dependences import dependences
from vividc.mapper.distances import hop_distances
from vividc.mapper.mapping import Place
from vividc.mapper.negotiate.claims import Claims
from vividc.mapper.problem import ConstantKey, MapProblem

_BROKEN: Final = 40.0
_LATE: Final = 20.0
_HOP: Final = 1.0
_CYCLE: Final = 0.4
_HOT: Final = 12.0
_WARM: Final = 3.0
_COLD: Final = 0.15
_TIGHT: Final = 0.7
_MOST_SPARE: Final = 4
_MOVE_PE: Final = 0.65
_MOVE_TIME: Final = 0.45
_LOOK_AT_CLOCK: Final = 2048


@dataclass(frozen=True, slots=True)
class _Edge:
    """A dependence: start[dst] >= start[src] + `shift`; a routed word lives start[dst] - start[src]
    - `ready` cycles after its result.
    """

    index: int
    src: int
    dst: int
    shift: int
    ready: int
    routed: bool


class Annealer:
    """Places and times of all nodes at one II.

    Attributes
    ----------
    places
        The present state.
    """

    def __init__(
        self, task: MapProblem, ii: int, start: Mapping[int, int], latest: int, seed: int
    ) -> None:
        self.task, self.ii, self.latest = task, ii, latest
        self.draw = random.Random(seed)
        self.hops = hop_distances(task.fabric)
        self.ids = [node.id for node in task.dfg.placed]
        self.candidates = {node.id: task.candidates(node) for node in task.dfg.placed}
        self.constants = {node.id: task.constants_of(node) for node in task.dfg.placed}
        self.edges: dict[int, list[_Edge]] = {node: [] for node in self.ids}
        self.spare: dict[int, int] = defaultdict(int)
        for index, edge in enumerate(dependences(task.dfg, task.fabric)):
            ahead = ii * edge.distance
            shift, ready = edge.separation - ahead, edge.latency - ahead
            seen = _Edge(index, edge.src, edge.dst, shift, ready, edge.routed)
            if edge.dst != edge.src:
                self.edges[edge.src].append(seen)
                self.edges[edge.dst].append(seen)
        self.claims = Claims(task, ii)
        self.held: dict[tuple[int, ConstantKey], int] = defaultdict(int)
        self.stored = [len(task.resident.get(pe.id, ())) for pe in task.fabric.pes]
        self.room = [max(pe.constants, self.stored[pe.id]) for pe in task.fabric.pes]
        for pe, keys in task.resident.items():
            for key in keys:
                self.held[pe, key] = 1
        self.places: dict[int, Place] = {}
        for node, time in start.items():
            self._put(node, Place(self._first_pe(node, time), time))

    def run(self, moves: int, deadline: Deadline, *, warm: bool = False) -> bool:
        """Anneal; True when nothing is broken in the end. `warm`: change what there is, gently."""
        heat = _WARM if warm else _HOT
        cooling = (_COLD / heat) ** (1.0 / max(moves, 1))
        for move in range(moves):
            if move % _LOOK_AT_CLOCK == 0 and deadline.passed:
                break
            self._step(heat)
            heat *= cooling
        return not self.is_broken()

    def loosen(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Words from the first to the second node of each pair had no free way: from now on they
        want a cycle more than they need.
        """
        wanted = set(pairs)
        for edges in self.edges.values():
            for edge in edges:
                if (edge.src, edge.dst) in wanted:
                    self.spare[edge.index] = min(self.spare[edge.index] + 1, _MOST_SPARE)

    def is_broken(self) -> bool:
        """Whether two nodes claim the same, a word comes late, or a constant store overflows."""
        crowded = self.claims.crowded() or any(
            stored > room for stored, room in zip(self.stored, self.room, strict=True)
        )
        return crowded or any(self._is_late(e) for node in self.ids for e in self.edges[node])

    # --- moves ---

    def _step(self, heat: float) -> None:
        node = self.ids[self.draw.randrange(len(self.ids))]
        old = self.places[node]
        new = self._proposal(node, old)
        if new is None:
            return
        other = self.claims.occupant(node, new)
        if other is None:
            moves = {node: new}
        elif old.pe in self.candidates[other]:
            moves = {node: new, other: Place(old.pe, self.places[other].time)}
        else:
            return
        before = {moved: self.places[moved] for moved in moves}
        cost = self._cost(moves)
        self._move(moves)
        change = self._cost(moves) - cost
        if change > 0 and self.draw.random() >= math.exp(-change / heat):
            self._move(before)

    def _proposal(self, node: int, place: Place) -> Place | None:
        pe, time = place.pe, place.time
        kind = self.draw.random()
        if kind < _MOVE_PE:
            pes = self.candidates[node]
            pe = pes[self.draw.randrange(len(pes))]
        if kind > _MOVE_TIME:
            first, last = self._window(node)
            if first > last:
                return None
            time = self.draw.randint(first, last)
        return None if pe == place.pe and time == place.time else Place(pe, time)

    def _window(self, node: int) -> tuple[int, int]:
        """Times that keep all dependences as the other nodes lie now."""
        first, last = 0, self.latest
        places = self.places
        for edge in self.edges[node]:
            if edge.dst == node:
                first = max(first, places[edge.src].time + edge.shift)
            else:
                last = min(last, places[edge.dst].time - edge.shift)
        return first, last

    def _move(self, new: Mapping[int, Place]) -> None:
        for node in new:
            self._take(node)
        for node, place in new.items():
            self._put(node, place)

    # --- costs ---

    def _cost(self, nodes: Iterable[int]) -> float:
        total = 0.0
        places, hops, spare = self.places, self.hops, self.spare
        for node in nodes:
            place = places[node]
            over = self.claims.excess(node, place) + max(
                0, self.stored[place.pe] - self.room[place.pe]
            )
            total += _BROKEN * over
            for edge in self.edges[node]:
                if not edge.routed:
                    continue
                src, dst = places[edge.src], places[edge.dst]
                distance = hops[src.pe][dst.pe]
                life = dst.time - src.time - edge.ready
                total += _HOP * distance + _CYCLE * life
                if distance > life + 1:
                    total += _LATE * (distance - life - 1)
                elif distance + spare.get(edge.index, 0) > life:
                    total += _TIGHT * (distance + spare.get(edge.index, 0) - life)
        return total

    def _is_late(self, edge: _Edge) -> bool:
        src, dst = self.places[edge.src], self.places[edge.dst]
        if dst.time < src.time + edge.shift:
            return True
        life = dst.time - src.time - edge.ready
        return edge.routed and self.hops[src.pe][dst.pe] > life + 1

    # --- state ---

    def _put(self, node: int, place: Place) -> None:
        self.places[node] = place
        self.claims.put(node, place)
        for key in self.constants[node]:
            if not self.held[place.pe, key]:
                self.stored[place.pe] += 1
            self.held[place.pe, key] += 1

    def _take(self, node: int) -> None:
        place = self.places[node]
        self.claims.take(node, place)
        for key in self.constants[node]:
            self.held[place.pe, key] -= 1
            if not self.held[place.pe, key]:
                self.stored[place.pe] -= 1

    def _first_pe(self, node: int, time: int) -> int:
        """The candidate nearest to the neighbours already placed, among those with a free slot."""
        placed = [
            self.places[other].pe
            for edge in self.edges[node]
            for other in (edge.src, edge.dst)
            if edge.routed and other in self.places
        ]

        def rank(pe: int) -> tuple[int, int, float]:
            taken = self.claims.excess(node, Place(pe, time))
            return taken, sum(self.hops[other][pe] for other in placed), self.draw.random()

        return min(self.candidates[node], key=rank)
