"""The modulo reservation table of nodes: who claims what in which slot (Rau 1994, section 3.1)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator
from typing import Final

from vividc.dfg.ir import Node
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Place
from vividc.mapper.problem import ConstantKey, MapProblem, constant_key

_ANY: Final = -1


class ReservationTable:
    """Claims of the nodes placed so far, each a key with a capacity.

    Attributes
    ----------
    places
        Where each scheduled node is.
    """

    def __init__(self, problem: MapProblem, ii: int) -> None:
        self.problem, self.ii = problem, ii
        self.places: dict[int, Place] = {}
        self._users: dict[Hashable, dict[int, None]] = defaultdict(dict)
        self._entries: dict[int, dict[ConstantKey, dict[int, None]]] = {
            pe.id: defaultdict(dict) for pe in problem.fabric.pes
        }
        self._constants = {node.id: problem.constants_of(node) for node in problem.dfg.placed}
        self._reads = {node.id: frozenset(self._live_ins(node)) for node in problem.dfg.placed}

    def in_the_way(self, node: Node, place: Place) -> list[int]:
        """Nodes to displace before `node` fits at `place`, latest first; empty: it fits."""
        nodes: dict[int, None] = {}
        for key, capacity in self._claims(node, place):
            users = list(self._users.get(key, ()))
            nodes |= dict.fromkeys(users[: max(len(users) - capacity + 1, 0)])
        nodes |= dict.fromkeys(self._rivals(node, place.pe))
        nodes |= dict.fromkeys(self._crowding_store(node, place.pe))
        return list(nodes)

    def enter(self, node: Node, place: Place) -> None:
        """Enter a node's claims."""
        self.places[node.id] = place
        for key, _ in self._claims(node, place):
            self._users[key][node.id] = None
        for entry in self._constants[node.id]:
            self._entries[place.pe][entry][node.id] = None

    def leave(self, node: Node) -> None:
        """Withdraw a node's claims."""
        place = self.places.pop(node.id)
        for key, _ in self._claims(node, place):
            del self._users[key][node.id]
        for entry in self._constants[node.id]:
            users = self._entries[place.pe][entry]
            del users[node.id]
            if not users:
                del self._entries[place.pe][entry]

    def _claims(self, node: Node, place: Place) -> Iterator[tuple[Hashable, int]]:
        """(key, capacity) of all that a node takes."""
        fabric, slot = self.problem.fabric, place.time % self.ii
        if not node.uses_fu:
            yield ("live-out", place.pe, slot), 1
            return
        yield ("issue", place.pe, slot), 1
        done = (place.time + fabric.latency(node)) % self.ii
        yield ("completion", place.pe, done), 1
        if node.is_memory:
            yield ("banks", _ANY, slot), fabric.scratchpad.banks
        if node.control is not None:
            yield ("control", _ANY, done), 1

    def _live_ins(self, node: Node) -> Iterator[ConstantKey]:
        for edge in self.problem.dfg.in_edges[node.id]:
            for source in (edge.src, edge.init):
                if source is not None and edge.is_data:
                    key = constant_key(self.problem.dfg.by_id[source])
                    if key is not None:
                        yield key

    def _rivals(self, node: Node, pe: int) -> Iterator[int]:
        """Live-outs that write an entry which the node reads on its PE, and the reverse."""
        nodes = self.problem.dfg.by_id
        is_live_out = node.op is Opcode.LIVE_OUT
        for key in self._constants[node.id]:
            for other in self._entries[pe].get(key, ()):
                writes = nodes[other].op is Opcode.LIVE_OUT
                written = ("live_in", nodes[other].name) == key and writes
                reads_mine = is_live_out and ("live_in", node.name) == key
                if (written and key in self._reads[node.id]) or (
                    reads_mine and key in self._reads[other]
                ):
                    yield other

    def _crowding_store(self, node: Node, pe: int) -> list[int]:
        """Users of the entries that must go for the node's own to fit."""
        resident = self.problem.resident.get(pe, frozenset())
        entries = self._entries[pe]
        wanted = set(self._constants[node.id])
        free = max(self.problem.fabric.pes[pe].constants, len(resident))
        held = resident | entries.keys()
        excess = len(held | wanted) - free
        if excess <= 0 or wanted <= held:
            return []
        crowding: list[int] = []
        for key, users in entries.items():
            if excess > 0 and key not in wanted and key not in resident:
                crowding += users
                excess -= 1
        return crowding
