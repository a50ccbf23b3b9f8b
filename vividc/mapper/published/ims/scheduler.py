"""Iterative modulo scheduling (Rau 1994, "Iterative modulo scheduling: an algorithm for software
pipelining loops", section 3), with places and routes.

Operations are scheduled by height; one that fits nowhere in II cycles from its earliest start is
forced in, and what is in its way is scheduled again, until a budget is spent; then the II grows.
Here a slot is a slot of a PE, and it fits only if the operands' words have ways to it on the MRRG;
readers that the result no longer reaches in time are displaced, as violated successors are there.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping as ReadOnly
from dataclasses import replace
from typing import Final

from vividc.dfg.ir import Edge, Node
from vividc.mapper.bounds.bounds import usable_pes
from vividc.mapper.deadline import Deadline
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.problem import MapProblem
from vividc.mapper.published.ims.table import ReservationTable
from vividc.mapper.published.ims.words import Result, Words
from vividc.mapper.published.upward import attempt_of, core_for, upward
from vividc.mapper.request import MapRequest
from vividc.mapper.resources.arrays import Ints
from vividc.mapper.resources.dependences import (
    Dependence,
    dependences,
    earliest_starts,
    longest_tails,
)
from vividc.mapper.resources.distances import FAR
from vividc.mapper.resources.mrrg import MRRG, build_mrrg
from vividc.mapper.result import MapResult
from vividc.mapper.search.state import OPEN, Attempt
from vividc.mapper.search.strategy import run

_BUDGET_RATIO: Final = 6
"""Scheduling steps per operation before the II grows (Rau 1994, section 4.3)."""


def ims(problem: MapProblem, request: MapRequest) -> MapResult:
    """Schedule, place and route operation by operation, from the MII upward.

    Raises
    ------
    VividcError
        The fabric's routing is not that of the MRRG.
    """
    core_for(problem.fabric, "ims")
    return run(upward("ims", _try_ii), problem, request)


def _try_ii(
    problem: MapProblem, ii: int, request: MapRequest, deadline: Deadline, tries: int
) -> Attempt:
    if tries:
        return OPEN  # nothing is random: it would fail again
    request.tell(f"II {ii}: iterative modulo scheduling")
    core = replace(problem, fabric=core_for(problem.fabric, "ims"))
    less: Counter[int] = Counter()
    for _ in range(_NAMINGS):
        schedule = _Schedule(core, ii, less, deadline)
        mapping = schedule.run()
        if mapping is not None or not schedule.words.crowded:
            return attempt_of(problem, mapping)
        less.update(schedule.words.crowded)
    return OPEN


_NAMINGS: Final = 6
"""Schedules of an II, each with a register less in the files whose words found no names before:
slots count words, and arcs on a circle may need one more register than the fullest slot has words.
"""


class _Schedule:
    """One II's partial schedule."""

    def __init__(
        self, problem: MapProblem, ii: int, less: ReadOnly[int, int], deadline: Deadline
    ) -> None:
        self.problem, self.ii, self.deadline = problem, ii, deadline
        self.graph: MRRG = build_mrrg(problem.fabric)
        self.reach: Ints = self.graph.reach
        self.farthest = int(self.reach[self.reach < FAR].max(initial=0))
        self.table = ReservationTable(problem, ii)
        self.words = Words(self.graph, ii, less, deadline)
        nodes = [node.id for node in problem.dfg.placed]
        self.edges: dict[int, list[tuple[int, Edge, Dependence]]] = {node: [] for node in nodes}
        placed = [(i, e) for i, e in enumerate(problem.dfg.edges) if e.src in self.edges]
        deps = dependences(problem.dfg, problem.fabric)
        for (index, edge), dependence in zip(placed, deps, strict=True):
            for end in dict.fromkeys((edge.src, edge.dst)):
                self.edges[end].append((index, edge, dependence))
        self.feasible = earliest_starts(nodes, deps, ii) is not None
        self.height = longest_tails(nodes, deps, ii) if self.feasible else {}
        self.last_time: dict[int, int] = {}

    def run(self) -> Mapping | None:
        """A mapping, or None if the budget or the time is used up."""
        if not self.feasible:
            return None
        nodes = self.problem.dfg.by_id
        left = {node.id for node in self.problem.dfg.placed}
        for _ in range(_BUDGET_RATIO * len(left)):
            if not left:
                break
            if self.deadline.passed:
                return None
            node = nodes[max(left, key=lambda n: (self.height[n], -n))]
            if not self._find_place(node) and (self.deadline.passed or not self._force(node)):
                return None
            left = {n.id for n in self.problem.dfg.placed} - self.table.places.keys()
        return None if left else self._mapping()

    def _find_place(self, node: Node) -> bool:
        """The first free slot that the operands can be routed to, on the nearest PE, within II
        cycles plus those that a word takes across the array.
        """
        earliest = self._earliest(node.id)
        candidates = self._nearest_first(node)
        for time in range(earliest, earliest + self.ii + self.farthest):
            if self.deadline.passed:
                return False
            for pe in candidates:
                place = Place(pe, time)
                if self._is_in_range(place) and self._in_time(node.id, place):
                    if self.table.in_the_way(node, place) or not self._operands_arrive(node, place):
                        continue
                    self._settle(node, place)
                    return True
        return False

    def _force(self, node: Node) -> bool:
        """Put the node somewhere and displace what is in its way; later than the last time it was
        tried, so that nothing repeats.
        """
        time = self._earliest(node.id)
        if node.id in self.last_time:
            time = max(time, self.last_time[node.id] + 1)
        candidates = self._nearest_first(node)
        place = Place(candidates[time % len(candidates)] if candidates else 0, time)
        if not candidates or not self._is_in_range(place):
            return False
        for other in self.table.in_the_way(node, place):
            self._displace(other)
        self._settle(node, place)
        return True

    def _settle(self, node: Node, place: Place) -> None:
        """Enter the node; neighbours that cannot be reached are displaced."""
        self.table.enter(node, place)
        self.last_time[node.id] = place.time
        for index, edge, dependence in self.edges[node.id]:
            ends = self.table.places.get(edge.src), self.table.places.get(edge.dst)
            if ends[0] is None or ends[1] is None or index in self.words.ways:
                continue
            if not self._connect(index, dependence, ends[0], ends[1]):
                self._displace(edge.dst if edge.src == node.id else edge.src)
                if node.id not in self.table.places:
                    return

    def _displace(self, node: int) -> None:
        if node in self.table.places:
            self.table.leave(self.problem.dfg.by_id[node])
        for index, _, _ in self.edges[node]:
            self.words.remove(index)

    def _operands_arrive(self, node: Node, place: Place) -> bool:
        """Whether all scheduled operands can be routed to the place; leaves no routes behind."""
        tried = []
        fine = True
        for index, edge, dependence in self.edges[node.id]:
            source = place if edge.src == node.id else self.table.places.get(edge.src)
            if edge.dst != node.id or source is None or not dependence.routed:
                continue
            fine = self._connect(index, dependence, source, place)
            tried.append(index)
            if not fine:
                break
        for index in tried:
            self.words.remove(index)
        return fine

    def _connect(self, index: int, dependence: Dependence, source: Place, sink: Place) -> bool:
        read = sink.time + self.ii * dependence.distance
        if not dependence.routed:
            return read >= source.time + dependence.separation
        result = Result(dependence.src, source.pe, source.time + dependence.latency)
        return self.words.route(index, result, sink.pe, read)

    def _earliest(self, node: int) -> int:
        starts = [
            self.table.places[edge.src].time + dependence.weight(self.ii)
            for _, edge, dependence in self.edges[node]
            if edge.dst == node and edge.src in self.table.places
        ]
        return max([0, *starts])

    def _in_time(self, node: int, place: Place) -> bool:
        """Whether the operands can arrive in time if everything is free."""
        return all(
            place.time + self.ii * edge.distance
            >= self.table.places[edge.src].time
            + dependence.latency
            + self.reach[self.table.places[edge.src].pe, place.pe]
            for _, edge, dependence in self.edges[node]
            if dependence.routed and edge.dst == node and edge.src in self.table.places
        )

    def _is_in_range(self, place: Place) -> bool:
        return place.time < self.ii * self.problem.fabric.controller.max_stages

    def _nearest_first(self, node: Node) -> list[int]:
        """Candidate PEs by distance to the scheduled neighbours, free ones before full ones."""
        near = [
            (self.table.places[other].pe, other == edge.src)
            for _, edge, dependence in self.edges[node.id]
            if dependence.routed
            for other in (edge.src, edge.dst)
            if other != node.id and other in self.table.places
        ]
        used = [place.pe for place in self.table.places.values()]

        def cost(pe: int) -> tuple[int, int, int]:
            ways = (self.reach[at, pe] if comes else self.reach[pe, at] for at, comes in near)
            return int(sum(ways)), used.count(pe), pe

        return sorted(usable_pes(self.problem, node), key=cost)

    def _mapping(self) -> Mapping | None:
        routes = self.words.steps()
        if routes is None:
            return None
        return Mapping(self.ii, dict(self.table.places), routes)
