"""An exhaustive modulo mapper for tiny graphs and fabrics, written from docs/machine.md alone.

It enumerates every time and PE of every node, and for each such placement every route. That is
complete:

*Times.* A node of stage s issues at a time below (s + 1) * II, and there are `max_stages` stages,
so the times of a legal mapping lie in [0, max_stages * II). Shifting all times by one constant
turns a legal mapping into a legal one, since every rule speaks of differences of times or of equal
slots, and all slots turn together; shifting down to 0 never adds a stage. So the first node may be
put at time 0 and the others within max_stages * II - 1 cycles before or after, as long as first
and last are less than max_stages * II apart; the result is shifted to begin at 0.

*Places.* All PEs, but for the first node only one of each class of PEs that an automorphism of the
fabric maps onto each other (unless some node is bound to PEs, which breaks the symmetry).

*Routes.* A word takes one step a cycle, and the length of a route follows from the times, so
walking every choice of link and register in every cycle is finite and complete. Of the registers
of a PE that no word uses in any slot only the first is tried: they are interchangeable.

A partial placement whose routes are impossible is given up: more nodes only add words.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Mapping as ReadOnly
from itertools import permutations

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Place, Step

Spot = tuple[str, int, int]


def minimum_ii(
    dfg: DFG, fabric: Fabric, *, allowed: ReadOnly[int, frozenset[int]] | None = None
) -> tuple[int, Mapping] | None:
    """The least II that the contexts permit, with a mapping; None if there is none."""
    for ii in range(1, fabric.controller.contexts + 1):
        found = mapping_at(dfg, fabric, ii, allowed=allowed)
        if found is not None:
            return ii, found
    return None


def mapping_at(
    dfg: DFG, fabric: Fabric, ii: int, *, allowed: ReadOnly[int, frozenset[int]] | None = None
) -> Mapping | None:
    """A mapping at this II, or None after all have been tried."""
    return _Placer(dfg, fabric, ii, allowed or {}).search()


class _Placer:
    """Depth-first over (PE, time) of the nodes."""

    def __init__(
        self, dfg: DFG, fabric: Fabric, ii: int, allowed: ReadOnly[int, frozenset[int]]
    ) -> None:
        self.dfg, self.fabric, self.ii, self.allowed = dfg, fabric, ii, allowed
        self.span = fabric.controller.max_stages * ii
        self.order = _connected_order(dfg)
        self.start: dict[int, tuple[int, int]] = {}
        self.routes: dict[int, tuple[Step, ...]] = {}
        self.hops = _hops(fabric)

    def search(self) -> Mapping | None:
        """The first mapping in the order of the enumeration."""
        if not self._extend(0):
            return None
        first = min((time for _, time in self.start.values()), default=0)
        places = {node: Place(pe, time - first) for node, (pe, time) in self.start.items()}
        routes = {
            index: tuple(Step(s.kind, s.pe, s.index, s.time - first) for s in route)
            for index, route in self.routes.items()
        }
        return Mapping(self.ii, places, routes)

    def _extend(self, depth: int) -> bool:
        if depth == len(self.order):
            return True
        node = self.order[depth]
        for pe, time in self._options(node, depth):
            self.start[node.id] = (pe, time)
            if self._is_consistent(node) and self._is_routable() and self._extend(depth + 1):
                return True
            del self.start[node.id]
        return False

    def _options(self, node: Node, depth: int) -> Iterator[tuple[int, int]]:
        pes = [
            pe.id
            for pe in self.fabric.pes
            if node.op is Opcode.LIVE_OUT or node.latency_class in pe.classes
        ]
        if node.id in self.allowed:
            pes = [pe for pe in pes if pe in self.allowed[node.id]]
        if depth == 0:
            if not self.allowed:
                pes = [pe for pe in pes if pe in _representatives(self.fabric)]
            yield from ((pe, 0) for pe in pes)
            return
        earliest = max(time for _, time in self.start.values()) - self.span + 1
        latest = min(time for _, time in self.start.values()) + self.span - 1
        for time in sorted(range(earliest, latest + 1), key=abs):
            yield from ((pe, time) for pe in pes)

    def _latency(self, node_id: int) -> int:
        return self.fabric.latencies[self.dfg.by_id[node_id].latency_class]

    def _is_consistent(self, node: Node) -> bool:
        pe, time = self.start[node.id]
        for other_id, (other_pe, other_time) in self.start.items():
            if other_id != node.id and self._collide(
                node, pe, time, self.dfg.by_id[other_id], other_pe, other_time
            ):
                return False
        placed = [e for e in self.dfg.edges if node.id in {e.src, e.dst} and self._both_placed(e)]
        if not all(self._far_enough(edge) for edge in placed) or not self._banks_suffice():
            return False
        return self._constants_fit(pe) and self._old_words_survive(pe)

    def _banks_suffice(self) -> bool:
        slots = [
            time % self.ii
            for node_id, (_, time) in self.start.items()
            if self.dfg.by_id[node_id].op in (Opcode.LOAD, Opcode.STORE)
        ]
        return all(slots.count(slot) <= self.fabric.scratchpad.banks for slot in slots)

    def _both_placed(self, edge: Edge) -> bool:
        return edge.src in self.start and edge.dst in self.start

    def _collide(self, a: Node, pe_a: int, time_a: int, b: Node, pe_b: int, time_b: int) -> bool:
        end_a, end_b = time_a + self._latency(a.id), time_b + self._latency(b.id)
        if a.control and b.control and (end_a - end_b) % self.ii == 0:
            return True
        if pe_a != pe_b or (a.op is Opcode.LIVE_OUT) != (b.op is Opcode.LIVE_OUT):
            return False
        same_issue = (time_a - time_b) % self.ii == 0
        return same_issue or (a.op is not Opcode.LIVE_OUT and (end_a - end_b) % self.ii == 0)

    def _far_enough(self, edge: Edge) -> bool:
        pe_src, time_src = self.start[edge.src]
        pe_dst, time_dst = self.start[edge.dst]
        gap = time_dst + self.ii * edge.distance - time_src
        if edge.kind is EdgeKind.ORDER:
            return gap >= 1
        gap -= self._latency(edge.src)
        if edge.kind is EdgeKind.CONTROL:
            return gap >= self.fabric.controller.control_latency
        return gap >= max(0, self.hops[pe_src][pe_dst] - 1)

    def _constants_fit(self, pe: int) -> bool:
        held: set[tuple[str, int | str]] = set()
        for node_id, (place, _) in self.start.items():
            if place == pe:
                held |= _entries(self.dfg, self.dfg.by_id[node_id])
        return len(held) <= self.fabric.pes[pe].constants

    def _old_words_survive(self, pe: int) -> bool:
        """A loop comes back to read, so no variable is read on a PE on which it is written."""
        here = [self.dfg.by_id[n] for n, (place, _) in self.start.items() if place == pe]
        written = {node.name for node in here if node.op is Opcode.LIVE_OUT}
        sources = (
            self.dfg.by_id[source]
            for node in here
            for edge in self.dfg.in_edges[node.id]
            for source in (edge.src, edge.init)
            if source is not None and edge.kind is EdgeKind.DATA
        )
        return not any(s.op is Opcode.LIVE_IN and s.name in written for s in sources)

    def _is_routable(self) -> bool:
        pending = []
        for index, edge in enumerate(self.dfg.edges):
            if edge.kind is EdgeKind.DATA and self._both_placed(edge):
                pe_src, time_src = self.start[edge.src]
                pe_dst, time_dst = self.start[edge.dst]
                ready = time_src + self._latency(edge.src)
                read = time_dst + self.ii * edge.distance
                pending.append(_Trip(index, edge.src, pe_src, ready, pe_dst, read))
        pending.sort(key=lambda trip: (trip.read - trip.ready, trip.value))
        board = _Board(self.fabric, self.ii, self.hops)
        if not board.route(pending):
            return False
        self.routes = board.routes
        return True


class _Trip:
    """A word to be brought from where it becomes ready to where it is read."""

    def __init__(self, index: int, value: int, pe: int, ready: int, to_pe: int, read: int) -> None:
        self.index, self.value, self.pe, self.ready = index, value, pe, ready
        self.to_pe, self.read = to_pe, read


class _Board:
    """The word of each link and register in each slot, its driver, and the ports in use."""

    def __init__(self, fabric: Fabric, ii: int, hops: list[list[int]]) -> None:
        self.fabric, self.ii, self.hops = fabric, ii, hops
        self.held: dict[tuple[Spot, int], list[tuple[int, int, Spot | None]]] = {}
        self.reads: dict[tuple[int, int], list[int]] = {}
        self.writes: dict[tuple[int, int], list[int]] = {}
        self.users: dict[Spot, int] = {}
        self.routes: dict[int, tuple[Step, ...]] = {}

    def route(self, pending: list[_Trip]) -> bool:
        """Whether all trips can be made together; `routes` then says how."""
        if not pending:
            return True
        trip = pending[0]
        for path in self._paths(trip, None, trip.pe, trip.ready, ()):
            self.routes[trip.index] = path
            if self.route(pending[1:]):
                return True
        return False

    def _paths(
        self, trip: _Trip, at: Spot | None, pe: int, time: int, path: tuple[Step, ...]
    ) -> Iterator[tuple[Step, ...]]:
        """All ways on for a word that `pe` could read in the cycle before `time` (or its result).

        While a path is handed out it is entered on the board.
        """
        if time == trip.ready == trip.read and pe == trip.to_pe:
            yield ()  # read from the FU's output register
        for spot, next_pe in self._moves(at, pe):
            left = trip.read - time
            if self.hops[next_pe][trip.to_pe] > left or not self._enter(trip.value, at, spot, time):
                continue
            step = Step("link" if spot[0] == "link" else "reg", next_pe, spot[2], time)
            if left == 0:
                yield from self._read_at_end(spot, pe=next_pe, time=time, path=(*path, step))
            else:
                yield from self._paths(trip, spot, next_pe, time + 1, (*path, step))
            self._leave(at, spot, time)

    def _read_at_end(
        self, spot: Spot, *, pe: int, time: int, path: tuple[Step, ...]
    ) -> Iterator[tuple[Step, ...]]:
        if spot[0] == "link":
            yield path
        elif self._take_port(self.reads, pe, time, spot[2], self.fabric.pes[pe].read_ports):
            yield path
            self._give_port(self.reads, pe, time, spot[2])

    def _moves(self, at: Spot | None, pe: int) -> Iterator[tuple[Spot, int]]:
        for link in self.fabric.links:
            if link.src == pe:
                yield ("link", 0, link.id), link.dst
        unused_tried = False
        for register in range(self.fabric.pes[pe].registers):
            spot = ("reg", pe, register)
            if not self.users.get(spot):
                if unused_tried:
                    continue
                unused_tried = True
            yield spot, pe

    def _enter(self, value: int, at: Spot | None, spot: Spot, time: int) -> bool:
        stack = self.held.setdefault((spot, time % self.ii), [])
        if stack and stack[-1] != (value, time, at):
            return False
        if not self._take_ports(at, spot, time):
            return False
        stack.append((value, time, at))
        self.users[spot] = self.users.get(spot, 0) + 1
        return True

    def _leave(self, at: Spot | None, spot: Spot, time: int) -> None:
        self.held[spot, time % self.ii].pop()
        self.users[spot] -= 1
        if at == spot:
            return
        if at is not None and at[0] == "reg":
            self._give_port(self.reads, at[1], time - 1, at[2])
        if spot[0] == "reg":
            self._give_port(self.writes, spot[1], time - 1, spot[2])

    def _take_ports(self, at: Spot | None, spot: Spot, time: int) -> bool:
        if at == spot:  # the register keeps its word
            return True
        reads = at is not None and at[0] == "reg"
        if reads and at is not None:
            ports = self.fabric.pes[at[1]].read_ports
            if not self._take_port(self.reads, at[1], time - 1, at[2], ports):
                return False
        if spot[0] == "link":
            return True
        ports = self.fabric.pes[spot[1]].write_ports
        if self._take_port(self.writes, spot[1], time - 1, spot[2], ports):
            return True
        if reads and at is not None:
            self._give_port(self.reads, at[1], time - 1, at[2])
        return False

    def _take_port(
        self, table: dict[tuple[int, int], list[int]], pe: int, time: int, register: int, ports: int
    ) -> bool:
        users = table.setdefault((pe, time % self.ii), [])
        if register not in users and len(set(users)) >= ports:
            return False
        users.append(register)
        return True

    def _give_port(
        self, table: dict[tuple[int, int], list[int]], pe: int, time: int, register: int
    ) -> None:
        table[pe, time % self.ii].remove(register)


def _entries(dfg: DFG, node: Node) -> set[tuple[str, int | str]]:
    held: set[tuple[str, int | str]] = set()
    if node.op is Opcode.LIVE_OUT:
        held.add(("live_in", node.name))
    for edge in dfg.in_edges[node.id]:
        sources = (edge.src,) if edge.init is None else (edge.src, edge.init)
        for source in (dfg.by_id[i] for i in sources if edge.kind is EdgeKind.DATA):
            if source.op is Opcode.LIVE_IN:
                held.add(("live_in", source.name))
            if source.op is Opcode.CONST and source.const is not None:
                held.add(("const", source.const))
    return held


def _connected_order(dfg: DFG) -> list[Node]:
    """Placed nodes such that each but the first of a component has an edge to an earlier one."""
    order: list[Node] = []
    left = list(dfg.placed)
    while left:
        known = {node.id for node in order}
        linked = [
            node
            for node in left
            if any(
                (e.src in known and e.dst == node.id) or (e.dst in known and e.src == node.id)
                for e in dfg.edges
            )
        ]
        order.append((linked or left)[0])
        left.remove(order[-1])
    return order


def _hops(fabric: Fabric) -> list[list[int]]:
    """All-pairs shortest paths (Floyd 1962)."""
    count = len(fabric.pes)
    far = 10**6
    hops = [[0 if a == b else far for b in range(count)] for a in range(count)]
    for link in fabric.links:
        hops[link.src][link.dst] = min(hops[link.src][link.dst], 1)
    for via in range(count):
        for a in range(count):
            for b in range(count):
                hops[a][b] = min(hops[a][b], hops[a][via] + hops[via][b])
    return hops


def _representatives(fabric: Fabric) -> frozenset[int]:
    """One PE, the lowest, of each orbit under the automorphisms of the fabric."""
    count = len(fabric.pes)
    kinds = [(p.classes, p.registers, p.read_ports, p.write_ports, p.constants) for p in fabric.pes]
    links = sorted((link.src, link.dst) for link in fabric.links)
    lowest = list(range(count))
    for image in permutations(range(count)):
        if any(kinds[pe] != kinds[image[pe]] for pe in range(count)):
            continue
        if sorted((image[a], image[b]) for a, b in links) == links:
            lowest = [min(lowest[pe], image[pe]) for pe in range(count)]
    return frozenset(pe for pe in range(count) if lowest[pe] == pe)
