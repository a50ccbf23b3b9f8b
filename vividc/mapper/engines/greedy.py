"""One greedy pass over a straight region: each node in turn is placed and its operands are routed,
where and when the array allows it soonest.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

from vividc.dfg.ir import Edge, EdgeKind, Node
from vividc.host import time_limit
from vividc.machine.opcodes import Opcode
from vividc.mapper.bounds.straight import Heights, end_after_start
from vividc.mapper.engines.refusals import Stuck
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.problem import ConstantKey, MapProblem
from vividc.mapper.resources.banks import Meets
from vividc.mapper.resources.router import (
    LINK_COST,
    UNREACHABLE,
    Journal,
    Path,
    Places,
    Router,
    Spot,
    Value,
)

_PATIENCE: Final = 8
"""Cycles by which a node may be late on one PE before the others are asked again."""


@dataclass(frozen=True, slots=True)
class Policy:
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


class _Option(NamedTuple):
    """A place, the better the less: the cycles that the region would have at least, and what else
    it costs; once it was tried both are known, before they are at least so much.
    """

    score: float
    cost: int
    time: int
    pe: int


class Schedule:
    """One greedy pass over the region."""

    def __init__(
        self,
        problem: MapProblem,
        places: Places,
        heights: Heights,
        policy: Policy,
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
        self.sources = {
            node.id: [edge.src for _, edge in self.operands[node.id]] for node in self.dfg.placed
        }
        self.uses = {node: Counter(sources) for node, sources in self.sources.items()}
        self.routed_from: dict[int, list[int]] = defaultdict(list)
        for index, edge in self.dfg.routed_edges():
            self.routed_from[edge.src].append(index)
        self.busy: dict[tuple[str, int, int], int] = {}
        self.entries = {node.id: frozenset(problem.constants_of(node)) for node in self.dfg.placed}
        self.constants: dict[int, frozenset[ConstantKey]] = self._fixed_constants()
        self.readers = self._readers_of_written_variables()
        self.written_after: dict[int, list[int]] = defaultdict(list)
        for live_out, readers in self.readers.items():
            for reader in readers:
                self.written_after[reader].append(live_out)
        self.issued: dict[int, tuple[int, ...]] = {}
        self.waits = 0.0
        self.horizon = 0
        self.order: dict[int, int] = {}
        self.registers = sum(pe.registers for pe in self.fabric.pes)
        self.hops = [[max(0, hops - 1) for hops in row] for row in places.distance]
        self.lowest = {
            node.id: (-heights.of[node.id] - policy.urgency.get(node.id, 0), node.id)
            for node in self.dfg.placed
        }

    def run(self, below: float = math.inf) -> Mapping | None:
        """Place every node; None, once it is sure to take as many cycles as `below`, with those in
        which accesses wait.

        Raises
        ------
        Stuck
            A node has no place.
        """
        waits = self._waits()
        ready = [node.id for node in self.dfg.placed if not waits[node.id]]
        followers = self._followers()
        while ready:
            time_limit.step("straight regions were scheduled")
            chosen = self._first(ready)
            ready.remove(chosen)
            place = self._place(self.dfg.by_id[chosen])
            if place.time + self.heights.after(chosen, place.pe) + self.waits >= below:
                return None
            for follower in followers[chosen]:
                waits[follower] -= 1
                if not waits[follower]:
                    ready.append(follower)
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

    def _first(self, ready: list[int]) -> int:
        """The one to place next: the highest; while many words are parked, one that frees some."""
        if len(self.router.parked) <= self.policy.pressure * self.registers:
            return min(ready, key=self.lowest.__getitem__)
        return min(ready, key=self._rank_under_pressure)

    def _rank_under_pressure(self, node: int) -> tuple[int, int, int, int]:
        newest = 0
        if self.policy.deep:
            newest = max((self.order.get(src, 0) for src in self.sources[node]), default=0)
        return self._words_added(node), -newest, *self.lowest[node]

    def _words_added(self, node: int) -> int:
        uses = self.uses[node]
        freed = sum(1 for source, count in uses.items() if self.unread[source] == count)
        return (1 if self.unread[node] else 0) - freed

    # --- placing ---

    def _place(self, node: Node) -> Place:
        option = self._best_option(node)
        if option is None:
            raise Stuck(node, self._why_stuck(node))
        self.waits += self._meeting(node, option.time)
        self.order[node.id] = len(self.order) + 1
        self.horizon = max(self.horizon, option.time + end_after_start(self.fabric, node))
        return self.start[node.id]

    def _best_option(self, node: Node) -> _Option | None:
        """Try places in the order of the best they could give; stop when no other can be better.
        The best one is taken.
        """
        earliest, extra = self._earliest(node), self._extra(node)
        queue = self._queue(node, earliest, extra)
        last_chance = self.horizon + 2 * self.grid.diameter + 2 * _PATIENCE
        best: _Option | None = None
        taken: _Option | None = None
        mark = self.journal.mark()
        while queue:
            option = heapq.heappop(queue)
            if best is not None and (option.score > best.score or _is_behind(option, best)):
                break
            self.journal.back_to(mark)
            taken = self._tried(node, option, extra)
            if taken is None:
                if option.time < max(last_chance, earliest[option.pe] + _PATIENCE):
                    later = option._replace(score=option.score + 1, time=option.time + 1)
                    heapq.heappush(queue, later)
            elif best is None or taken < best:
                best = taken
        if best is None or taken is not best:
            self.journal.back_to(mark)
        if best is not None and taken is not best:
            cost = self._try(node, best.pe, best.time)
            assert cost is not None, "a trial placement does not repeat"
        return best

    def _queue(self, node: Node, earliest: list[int], extra: list[int]) -> list[_Option]:
        """What is to be tried first on each PE, as a heap."""
        hops = self._hops(node)
        queue: list[_Option] = []
        for pe in self.problem.candidates(node):
            time = earliest[pe]
            if time < UNREACHABLE and self._constants_fit(node, pe):
                score = time + self.heights.after(node.id, pe) + self._crowding(node, pe)
                queue.append(_Option(score, extra[pe] + LINK_COST * hops[pe], time, pe))
        heapq.heapify(queue)
        return queue

    def _extra(self, node: Node) -> list[int]:
        """By PE, what a place costs beside the routes that lead to it."""
        entries, policy = self.entries[node.id], self.policy
        extra = [policy.affinity * away for away in self._away(node)]
        for pe, held in self.constants.items() if entries else ():
            extra[pe] += policy.constants * len(entries - held)
        return extra

    def _hops(self, node: Node) -> list[int]:
        """By PE, links at least that words take which `node` reads there."""
        rows = []
        for source in self.uses[node.id]:
            held = dict.fromkeys(self.router.pes_of(self.values[source]))
            near = [self.grid.distance[pe] for pe in held]
            rows.append(list(map(min, *near)) if len(near) > 1 else near[0])
        return _added(rows, len(self.fabric.pes))

    def _meeting(self, node: Node, time: int) -> float:
        """Cycles that an access is expected to wait for the others of its cycle so far, at most
        one.
        """
        often = self.meets.get(node.id)
        if not often:
            return 0.0
        others = (other for other in self.issued.get(time, ()) if other != node.id)
        return min(1.0, sum(often.get(other, 0.0) for other in others))

    def _tried(self, node: Node, option: _Option, extra: list[int]) -> _Option | None:
        """What becomes of a place that may work, which is taken then; if it does not, None, and
        what was changed for it is still to be taken back.
        """
        score, _, time, pe = option
        if not self._is_free(node, pe, time):
            return None
        late = self.policy.apart * self._meeting(node, time)
        cost = self._try(node, pe, time)
        return None if cost is None else _Option(score + late, extra[pe] + cost, time, pe)

    def _away(self, node: Node) -> list[int]:
        """Hops from each PE to the words that the readers of `node` will need as well."""
        readers = (self.dfg.edges[index].dst for index in self.routed_from[node.id])
        others = (source for reader in readers for source in self.sources[reader])
        rows = [self.grid.distance[self.start[o].pe] for o in others if o in self.start]
        return _added(rows, len(self.fabric.pes))

    def _earliest(self, node: Node) -> list[int]:
        """By PE, the first cycle in which what comes before `node` lets it begin."""
        earliest = [0] * len(self.fabric.pes)
        for edge in self.dfg.in_edges[node.id]:
            before = self.start.get(edge.src)
            if before is None:
                continue
            ready = before.time + self.fabric.latency(self.dfg.by_id[edge.src])
            if edge.is_data:
                hops = self.hops[before.pe]
                earliest = list(map(max, earliest, [ready + hop for hop in hops]))
                continue
            if edge.kind is EdgeKind.ORDER:
                ready = before.time + 1
            else:
                ready += self.fabric.controller.control_latency
            earliest = [max(time, ready) for time in earliest]
        for reader in self.readers.get(node.id, ()):
            if reader in self.start:
                place = self.start[reader]
                earliest[place.pe] = max(earliest[place.pe], place.time)
        return earliest

    def _latest(self, node: Node, pe: int) -> int:
        """The write of a variable on this PE that `node` must not follow."""
        written = [
            self.start[live_out].time
            for live_out in self.written_after.get(node.id, ())
            if live_out in self.start and self.start[live_out].pe == pe
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
        if not self.entries[node.id] <= self.constants[pe]:
            self.journal.set(self.constants, pe, self.constants[pe] | self.entries[node.id])
        value = Value(node.id, pe, time + self.fabric.latency(node))
        self.journal.set(self.values, node.id, value)
        for source in self.uses[node.id]:
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
                held[home[0]] |= self.entries[node.id]
        return held

    def _constants_fit(self, node: Node, pe: int) -> bool:
        entries = self.entries[node.id]
        if entries <= self.constants[pe]:
            return True
        return len(entries | self.constants[pe]) <= self.fabric.pes[pe].constants

    def _crowding(self, node: Node, pe: int) -> int:
        """Cycles that a place may be later than one here, to leave a nearly full store alone."""
        if not self.policy.spared:
            return 0
        new = self.entries[node.id] - self.constants[pe]
        left = self.fabric.pes[pe].constants - len(self.constants[pe]) - len(new)
        return len(new) * max(self.policy.spared - left, 0)

    def _why_stuck(self, node: Node) -> str:
        candidates = self.problem.candidates(node)
        if not any(self._constants_fit(node, pe) for pe in candidates):
            return "no constant store of a PE that could take it has room for its constants"
        earliest = self._earliest(node)
        if all(earliest[pe] >= UNREACHABLE for pe in candidates):
            return "no links lead from its operands to a PE that could take it"
        if len(self.router.parked) >= self.registers:
            return f"all {self.registers} registers hold words that are still needed"
        words = len(self.uses[node.id])
        if all(words > self._words_at_once(pe) for pe in candidates):
            return f"it reads {words} words at once, more than links and read ports of a PE bring"
        return "no cycle has links and register ports free for its operands and its result"

    def _words_at_once(self, pe: int) -> int:
        return len(self.grid.into[pe]) + self.fabric.pes[pe].read_ports


def _is_behind(option: _Option, best: _Option) -> bool:
    """Whether neither it nor any that comes after it can be better. (One that waits for a bank has
    a greater score than it had before: with others that fail now and come later it is compared.)
    """
    return option > best and option.score + 1 > best.score


def _added(rows: list[list[int]], length: int) -> list[int]:
    """The sum of rows, element by element."""
    if not rows:
        return [0] * length
    return rows[0] if len(rows) == 1 else list(map(sum, zip(*rows, strict=True)))
