"""List scheduling of straight regions: place and route each node as early as the array allows.

The classic greedy (Graham 1966; heights as priorities: Coffman 1976, chapter 2), with routing as
part of the placement, and repeated with the priority of late nodes raised (squeaky wheel: Joslin
and Clements 1999). Words that wait keep a register, so a placement can always be completed later
(see `router`); it fails when registers or constant stores are full, or when a PE can bring together
fewer words than an operation reads.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from vividc.dfg.ir import Edge, EdgeKind, Node
from vividc.host import time_limit
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.straight import Heights, end_after_start, straight_lower_bound
from vividc.mapper.engines.refusals import (
    Stuck,
    failure_of,
    refuse_impossible,
    refuse_too_long,
)
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.resources.banks import NO_MEETS, Meets
from vividc.mapper.resources.router import UNREACHABLE, Journal, Path, Places, Router, Spot, Value

__all__ = ["list_schedule", "straight_lower_bound"]

_NODES_IN_ALL_TRIALS: Final = 1200
_MAX_TRIALS: Final = 24
_SPARED: Final = 12
"""Entries of constant stores: a store or load, its address and a number take three."""

_APART: Final = (2, 4, 1)
"""By trial."""

_PATIENCE: Final = 8
"""Cycles by which a node may be late on one PE before the others are asked again."""


def list_schedule(
    problem: MapProblem,
    goes_on: Callable[[], bool] = lambda: True,
    *,
    frugal: bool = False,
    meets: Meets = NO_MEETS,
) -> Mapping:
    """A legal schedule of a straight region; its `ii` is the length in cycles (1 or more).

    Deterministic, but for what `goes_on` says. The length is minimal when it equals
    `straight_lower_bound(problem).ii`; it may be longer where accesses meet in fewer banks for it.

    Parameters
    ----------
    goes_on
        Whether a shorter one is to be tried for, asked when there is one.
    frugal
        Rather longer than with entries in constant stores that are nearly full, which regions
        scheduled later need.
    meets
        How often each two accesses of one cycle meet in a bank.

    Raises
    ------
    MappingFailed
        A node fits no PE, the words alive do not fit the registers, or the region is longer than
        the configuration memory.
    TimeLimit
        Time is up (`time_limit`).
    """
    refuse_impossible(problem)
    bound = straight_lower_bound(problem)
    refuse_too_long(problem, bound.ii)
    heights = Heights(problem)
    places = Places(problem.fabric)
    urgency: dict[int, int] = {}
    best: Mapping | None = None
    least = math.inf
    failure: Stuck | None = None
    for trial in range(_trials(problem)):
        policy = _policy(trial, urgency, failure is not None, frugal)
        schedule = _Schedule(problem, places, heights, policy, meets)
        try:
            mapping = schedule.run()
        except Stuck as stuck:
            failure = stuck
            continue
        cycles = mapping.ii + schedule.waits
        if best is None or cycles < least:
            best, least = mapping, cycles
        if least < bound.ii + 1 or not goes_on():
            break
        urgency = _raised(urgency, heights, mapping, bound.ii)
    if best is None:
        raise failure_of(problem, failure)
    refuse_too_long(problem, best.ii)
    return best


def _trials(problem: MapProblem) -> int:
    return max(3, min(_MAX_TRIALS, _NODES_IN_ALL_TRIALS // max(1, len(problem.dfg.placed))))


# --- trials ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Policy:
    """How one trial decides. Above `pressure` parked words per register, readers go first, of these
    if `deep` those of the newest words: chains beside each other come one after the other. A store
    with less than `spared` entries left is avoided by a cycle for each that is missing. An access
    is `apart` cycles late rather than that it meets another one in a bank.
    """

    urgency: dict[int, int]
    pressure: float
    deep: bool
    affinity: int
    constants: int
    spared: int
    apart: int


def _policy(trial: int, urgency: dict[int, int], crowded: bool, frugal: bool) -> _Policy:
    deep = crowded and trial % 2 == 1
    return _Policy(
        urgency,
        pressure=0.0 if deep else 0.25 if crowded else 0.6,
        deep=deep,
        affinity=(2, 0, 4)[trial % 3],
        constants=8 if crowded or frugal else 1,
        spared=_SPARED if frugal else 0,
        apart=_APART[trial % len(_APART)],
    )


def _raised(
    urgency: dict[int, int], heights: Heights, mapping: Mapping, target: int
) -> dict[int, int]:
    """Raise the priority of nodes that make the schedule longer than `target`, by the excess."""
    raised = dict(urgency)
    for node, place in mapping.places.items():
        late = place.time + heights.of[node] - target
        if late > 0:
            raised[node] = raised.get(node, 0) + late
    return raised


@dataclass(frozen=True, slots=True)
class _Option:
    """A place that was tried and works, with what it costs."""

    score: float
    cost: int
    time: int
    pe: int

    @property
    def rank(self) -> tuple[float, int, int, int]:
        """The better the less."""
        return self.score, self.cost, self.time, self.pe


class _Schedule:
    """One greedy pass over the region."""

    def __init__(
        self,
        problem: MapProblem,
        places: Places,
        heights: Heights,
        policy: _Policy,
        meets: Meets,
    ) -> None:
        self.problem, self.dfg, self.fabric = problem, problem.dfg, problem.fabric
        self.grid, self.heights, self.policy, self.meets = places, heights, policy, meets
        self.journal = Journal()
        self.router = Router(places, self.journal)
        self.start: dict[int, Place] = {}
        self.values: dict[int, Value] = {}
        self.routes: dict[int, tuple[Spot, ...]] = {}
        self.unread: dict[int, int] = defaultdict(int)
        for _, edge in self.dfg.routed_edges():
            self.unread[edge.src] += 1
        self.operands: dict[int, list[tuple[int, Edge]]] = defaultdict(list)
        for index, edge in self.dfg.routed_edges():
            self.operands[edge.dst].append((index, edge))
        self.routed_from: dict[int, list[int]] = defaultdict(list)
        for index, edge in self.dfg.routed_edges():
            self.routed_from[edge.src].append(index)
        self.busy: dict[tuple[str, int, int], int] = {}
        self.constants: dict[int, frozenset[ConstantKey]] = self._fixed_constants()
        self.readers = self._readers_of_written_variables()
        self.issued: dict[int, tuple[int, ...]] = {}
        self.waits = 0.0
        self.horizon = 0
        self.order: dict[int, int] = {}
        self.registers = sum(pe.registers for pe in self.fabric.pes)

    def run(self) -> Mapping:
        """Place every node; raises `Stuck` when one has no place."""
        waits = self._waits()
        ready = [node for node in self.dfg.placed if not waits[node.id]]
        followers = self._followers()
        while ready:
            time_limit.step("straight regions were scheduled")
            node = min(ready, key=self._rank)
            ready.remove(node)
            self._place(node)
            for follower in followers[node.id]:
                waits[follower] -= 1
                if not waits[follower]:
                    ready.append(self.dfg.by_id[follower])
        for node in self.dfg.placed:
            if node.id not in self.start:
                raise Stuck(node, "its dependences form a cycle")
        return self._mapping()

    def _mapping(self) -> Mapping:
        ends = (
            place.time + end_after_start(self.fabric, self.dfg.by_id[node])
            for node, place in self.start.items()
        )
        routes = {
            index: tuple(self.grid.step(spot) for spot in route)
            for index, route in sorted(self.routes.items())
        }
        return Mapping(max(ends, default=1), dict(sorted(self.start.items())), routes)

    # --- order ---

    def _precedences(self) -> Iterator[tuple[int, int]]:
        for edge in self.dfg.edges:
            if not self.dfg.by_id[edge.src].is_source:
                yield edge.src, edge.dst
        for live_out, readers in self.readers.items():
            if not self.dfg.out_edges[live_out]:  # then nothing that reads can depend on the write
                yield from ((reader, live_out) for reader in readers if reader != live_out)

    def _waits(self) -> dict[int, int]:
        waits = {node.id: 0 for node in self.dfg.placed}
        for _, dst in self._precedences():
            waits[dst] += 1
        return waits

    def _followers(self) -> dict[int, list[int]]:
        followers: dict[int, list[int]] = {node.id: [] for node in self.dfg.placed}
        for src, dst in self._precedences():
            followers[src].append(dst)
        return followers

    def _readers_of_written_variables(self) -> dict[int, tuple[int, ...]]:
        """For each live-out, the nodes that read the word its variable had before the region."""
        readers: dict[str, list[int]] = defaultdict(list)
        for node in self.dfg.placed:
            for edge in self.dfg.in_edges[node.id]:
                source = self.dfg.by_id[edge.src]
                if source.op is Opcode.LIVE_IN and edge.is_data:
                    readers[source.name].append(node.id)
        outs = (node for node in self.dfg.placed if node.op is Opcode.LIVE_OUT)
        return {out.id: tuple(dict.fromkeys(readers[out.name])) for out in outs}

    def _rank(self, node: Node) -> tuple[int, int, int, int]:
        height = self.heights.of[node.id] + self.policy.urgency.get(node.id, 0)
        if len(self.router.parked) <= self.policy.pressure * self.registers:
            return 0, 0, -height, node.id
        newest = 0
        if self.policy.deep:
            newest = max(
                (self.order.get(edge.src, 0) for _, edge in self.operands[node.id]), default=0
            )
        return self._words_added(node), -newest, -height, node.id

    def _words_added(self, node: Node) -> int:
        counts: dict[int, int] = defaultdict(int)
        for _, edge in self.operands[node.id]:
            counts[edge.src] += 1
        freed = sum(1 for source, count in counts.items() if self.unread[source] == count)
        return (1 if self.unread[node.id] else 0) - freed

    # --- placing ---

    def _place(self, node: Node) -> None:
        option = self._best_option(node)
        if option is None:
            raise Stuck(node, self._why_stuck(node))
        self.waits += self._meeting(node, option.time)
        cost = self._try(node, option.pe, option.time)
        assert cost is not None, "a trial placement does not repeat"
        self.order[node.id] = len(self.order) + 1
        self.horizon = max(self.horizon, option.time + end_after_start(self.fabric, node))

    def _best_option(self, node: Node) -> _Option | None:
        """Try places in the order of the best they could give; stop when no other can be better."""
        queue = []
        for pe in self.problem.candidates(node):
            time = self._earliest(node, pe)
            if time < UNREACHABLE and self._constants_fit(node, pe):
                score = time + self.heights.after(node.id, pe) + self._crowding(node, pe)
                queue.append((score, time, pe))
        heapq.heapify(queue)
        last_chance = self.horizon + 2 * self.grid.diameter + 2 * _PATIENCE
        best: _Option | None = None
        while queue:
            score, time, pe = heapq.heappop(queue)
            if best is not None and score > best.score:
                break
            option = self._tried(node, pe, time, score)
            if option is None:
                if time < max(last_chance, self._earliest(node, pe) + _PATIENCE):
                    heapq.heappush(queue, (score + 1, time + 1, pe))
            elif best is None or option.rank < best.rank:
                best = option
        return best

    def _meeting(self, node: Node, time: int) -> float:
        """Cycles that an access is expected to wait for those of its cycle so far, at most one."""
        often = self.meets.get(node.id)
        if not often:
            return 0.0
        return min(1.0, sum(often.get(other, 0.0) for other in self.issued.get(time, ())))

    def _tried(self, node: Node, pe: int, time: int, score: int) -> _Option | None:
        if not self._is_free(node, pe, time):
            return None
        mark = self.journal.mark()
        cost = self._try(node, pe, time)
        self.journal.back_to(mark)
        if cost is None:
            return None
        new_entries = frozenset(self.problem.constants_of(node)) - self.constants[pe]
        cost += self.policy.constants * len(new_entries)
        cost += self.policy.affinity * self._away(node, pe)
        late = self.policy.apart * self._meeting(node, time)
        return _Option(score + late, cost, time, pe)

    def _away(self, node: Node, pe: int) -> int:
        """Hops to the words that the readers of `node` will need as well."""
        away = 0
        for index in self.routed_from[node.id]:
            for _, edge in self.operands[self.dfg.edges[index].dst]:
                if edge.src in self.start:
                    away += self.grid.distance[self.start[edge.src].pe][pe]
        return away

    def _earliest(self, node: Node, pe: int) -> int:
        earliest = 0
        for edge in self.dfg.in_edges[node.id]:
            before = self.start.get(edge.src)
            if before is None:
                continue
            producer = self.dfg.by_id[edge.src]
            ready = before.time + self.fabric.latency(producer)
            if edge.kind is EdgeKind.ORDER:
                ready = before.time + 1
            elif edge.kind is EdgeKind.CONTROL:
                ready += self.fabric.controller.control_latency
            else:
                ready += max(0, self.grid.distance[before.pe][pe] - 1)
            earliest = max(earliest, ready)
        for reader in self.readers.get(node.id, ()):
            if reader in self.start and self.start[reader].pe == pe:
                earliest = max(earliest, self.start[reader].time)
        return earliest

    def _latest(self, node: Node, pe: int) -> int:
        """The write of a variable on this PE that `node` must not follow."""
        written = [
            self.start[live_out].time
            for live_out, readers in self.readers.items()
            if node.id in readers and live_out in self.start and self.start[live_out].pe == pe
        ]
        return min(written, default=UNREACHABLE)

    def _is_free(self, node: Node, pe: int, time: int) -> bool:
        if time > self._latest(node, pe):
            return False
        return all(key not in self.busy for key in self._claims(node, pe, time))

    def _claims(self, node: Node, pe: int, time: int) -> Iterator[tuple[str, int, int]]:
        if node.op is Opcode.LIVE_OUT:
            yield "live_out", pe, time
            return
        done = time + self.fabric.latency(node)
        yield from (("issue", pe, time + k) for k in range(self.fabric.occupancy(node)))
        yield "completion", pe, done
        if node.control is not None:
            yield "control", 0, done
        if node.is_memory:
            banks = range(self.fabric.scratchpad.banks)
            free = (bank for bank in banks if ("bank", bank, time) not in self.busy)
            yield "bank", next(free, 0), time

    def _try(self, node: Node, pe: int, time: int) -> int | None:
        """Place `node`, route its operands, park its result; the routes' cost, or None."""
        cost = self._route_operands(node, pe, time)
        if cost is None:
            return None
        self.journal.set(self.start, node.id, Place(pe, time))
        for claim in self._claims(node, pe, time):
            self.journal.set(self.busy, claim, node.id)
        if node.id in self.meets:
            self.journal.set(self.issued, time, (*self.issued.get(time, ()), node.id))
        entries = self.constants[pe] | frozenset(self.problem.constants_of(node))
        self.journal.set(self.constants, pe, entries)
        value = Value(node.id, pe, time + self.fabric.latency(node))
        self.journal.set(self.values, node.id, value)
        for source in dict.fromkeys(edge.src for _, edge in self.operands[node.id]):
            if not self.unread[source]:
                self._settle(source)
        if self.unread[node.id] and not self.router.park(value):
            return None
        return cost

    def _route_operands(self, node: Node, pe: int, time: int) -> int | None:
        """Route in turn; when one fails, again with it first: order decides ports and links."""
        pending = list(self.operands[node.id])
        for _ in range(len(pending) + 1):
            mark = self.journal.mark()
            cost, failed = self._route_in_order(pending, pe, time)
            if failed is None:
                return cost
            self.journal.back_to(mark)
            if failed == 0:
                return None
            pending.insert(0, pending.pop(failed))
        return None

    def _route_in_order(
        self, pending: list[tuple[int, Edge]], pe: int, time: int
    ) -> tuple[int, int | None]:
        cost = 0
        for position, (index, edge) in enumerate(pending):
            value = self.values[edge.src]
            path: Path | None = self.router.find(value, pe, time)
            if path is None:
                return cost, position
            route = self.router.enter(value, path, pe, time)
            self.journal.set(self.routes, index, route)
            self.journal.set(self.unread, edge.src, self.unread[edge.src] - 1)
            cost += path.cost
        return cost, None

    def _settle(self, source: int) -> None:
        self.router.settle(source, [self.routes[index] for index in self.routed_from[source]])

    # --- constant stores ---

    def _fixed_constants(self) -> dict[int, frozenset[ConstantKey]]:
        """What the stores hold at first: other regions' entries, those of nodes with one home."""
        held = {pe.id: frozenset(self.problem.resident.get(pe.id, ())) for pe in self.fabric.pes}
        for node in self.dfg.placed:
            home = self.problem.candidates(node)
            if len(home) == 1:
                held[home[0]] |= frozenset(self.problem.constants_of(node))
        return held

    def _constants_fit(self, node: Node, pe: int) -> bool:
        entries = frozenset(self.problem.constants_of(node))
        if entries <= self.constants[pe]:
            return True
        return len(entries | self.constants[pe]) <= self.fabric.pes[pe].constants

    def _crowding(self, node: Node, pe: int) -> int:
        """Cycles that a place may be later than one here, to leave a nearly full store alone."""
        if not self.policy.spared:
            return 0
        new = frozenset(self.problem.constants_of(node)) - self.constants[pe]
        left = self.fabric.pes[pe].constants - len(self.constants[pe]) - len(new)
        return len(new) * max(self.policy.spared - left, 0)

    def _why_stuck(self, node: Node) -> str:
        candidates = self.problem.candidates(node)
        if not any(self._constants_fit(node, pe) for pe in candidates):
            return "no constant store of a PE that could take it has room for its constants"
        if all(self._earliest(node, pe) >= UNREACHABLE for pe in candidates):
            return "no links lead from its operands to a PE that could take it"
        if len(self.router.parked) >= self.registers:
            return f"all {self.registers} registers hold words that are still needed"
        words = len({edge.src for _, edge in self.operands[node.id]})
        if all(words > self._words_at_once(pe) for pe in candidates):
            return f"it reads {words} words at once, more than links and read ports of a PE bring"
        return "no cycle has links and register ports free for its operands and its result"

    def _words_at_once(self, pe: int) -> int:
        return len(self.grid.into[pe]) + self.fabric.pes[pe].read_ports
