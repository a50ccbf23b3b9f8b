"""What a mapper is asked: a DFG, a fabric, and what the rest of the program has already decided."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Node
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode

ConstantKey = tuple[str, int | str]
"""An entry of a constant store: ("const", word) or ("live_in", name)."""


@dataclass(frozen=True)
class Taken:
    """What a mapped region takes.

    Attributes
    ----------
    issued, completed, shown
        (PE, cycle) in which its operations issue, its results are in output registers, and its
        live-outs take the port of the constant store.
    words
        (kind, PE, index, cycle) of links and registers that hold its words, as in `mapping.Step`.
    written, read
        (PE, register, cycle) in which ports of the register file are taken.
    accesses
        (cycle, array, whether it is a store) to the scratchpad.
    """

    issued: frozenset[tuple[int, int]]
    completed: frozenset[tuple[int, int]]
    shown: frozenset[tuple[int, int]]
    words: frozenset[tuple[str, int, int, int]]
    written: frozenset[tuple[int, int, int]]
    read: frozenset[tuple[int, int, int]]
    accesses: frozenset[tuple[int, str, bool]]

    def meeting(self, name: str, is_store: bool) -> Iterator[int]:
        """Cycles of its accesses that may meet one to an array, and of which either stores."""
        for cycle, array, stores in self.accesses:
            if (stores or is_store) and (array == name or not (array and name)):
                yield cycle

    def _all(self) -> Hashable:
        taken = (self.issued, self.completed, self.shown, self.words, self.written, self.read)
        return taken, self.accesses


@dataclass(frozen=True)
class Fill(Taken):
    """What a loop takes in its first cycles, in which the straight region before it may end
    (docs/machine.md), by that region's cycles. The region accesses an array before the loop if
    either of the two stores, and nothing in the same cycle.

    Attributes
    ----------
    cycles
        So many are told of.
    entries_read, entries_written
        By PE and entry of its constant store, after how many cycles the loop does first.
    begin
        The cycle of the region in which the loop is to begin.
    expected
        So many cycles of the loop the region is expected to end in.
    """

    cycles: int
    entries_read: ReadOnly[tuple[int, ConstantKey], int]
    entries_written: ReadOnly[tuple[int, ConstantKey], int]
    begin: int = 0
    expected: int = 0

    def renamed(self, names: ReadOnly[Any, object]) -> Hashable:
        """What a mapper looks at, with other names for the entries that matter."""
        read, written = (
            frozenset((pe, names[key], cycle) for (pe, key), cycle in some.items() if key in names)
            for some in (self.entries_read, self.entries_written)
        )
        return self.begin, self.expected, self._all(), read, written

    def after(self, node: Node, key: ConstantKey, pes: Iterable[int]) -> int | None:
        """Cycles of the loop before which it needs what a node writes to an entry, or that it has
        been read; None: it does not.
        """
        some = self.entries_read if node.op is Opcode.LIVE_OUT else self.entries_written
        return min((some[pe, key] for pe in pes if (pe, key) in some), default=None)

    def accessed_after(self, node: Node) -> int | None:
        """Cycles of the loop before which an access has to be made; None: it does not matter."""
        first = min(self.meeting(node.name, node.op is Opcode.STORE), default=None)
        return None if first is None else first - self.begin


@dataclass(frozen=True)
class Drain(Taken):
    """What the last iterations of a loop still take when the straight region behind it begins
    (docs/machine.md), by that region's cycles. The region accesses an array after the loop if
    either of the two stores, and nothing in the same cycle.

    Attributes
    ----------
    cycles
        After which nothing of it is left.
    entries_read, entries_written
        (PE, entry of its constant store, cycle): the last one in which it reads it, and the first
        in which what it wrote can be read.
    """

    cycles: int
    entries_read: frozenset[tuple[int, ConstantKey, int]]
    entries_written: frozenset[tuple[int, ConstantKey, int]]

    @cached_property
    def readable_from(self) -> ReadOnly[tuple[int, ConstantKey], int]:
        """Where the drain writes an entry, from which cycle on it holds that."""
        return {(pe, key): cycle for pe, key, cycle in self.entries_written}

    @cached_property
    def writable_from(self) -> ReadOnly[tuple[int, ConstantKey], int]:
        """Where the drain reads an entry, or writes it, from which cycle on others may write it."""
        read = {(pe, key): cycle for pe, key, cycle in self.entries_read}
        both = read.keys() | self.readable_from.keys()
        return {at: max(read.get(at, 0), self.readable_from.get(at, 0)) for at in both}

    def renamed(self, names: ReadOnly[Any, object]) -> Hashable:
        """What a mapper looks at, with other names for the entries that matter."""
        read, written = (
            frozenset((pe, names[key], cycle) for pe, key, cycle in some if key in names)
            for some in (self.entries_read, self.entries_written)
        )
        return self.cycles, self._all(), read, written

    def accessible_from(self, node: Node) -> int:
        """The cycle from which on the region may make an access, but for those with accesses."""
        return 1 + max(self.meeting(node.name, node.op is Opcode.STORE), default=-1)


@dataclass(frozen=True)
class MapProblem:
    """One region to map.

    Attributes
    ----------
    allowed
        PEs a node may lie on, for the nodes that are not free (live-outs with a fixed home).
    resident
        Entries that other regions already hold in the constant store of each PE; they count towards
        its capacity, and using one again costs nothing.
    drain, fill
        Of a straight region: what is left of the loop before it, and what the one behind it takes
        that begins before it ends.
    """

    dfg: DFG
    fabric: Fabric
    allowed: ReadOnly[int, frozenset[int]] = field(default_factory=dict)
    resident: ReadOnly[int, frozenset[ConstantKey]] = field(default_factory=dict)
    drain: Drain | None = None
    fill: Fill | None = None

    def candidates(self, node: Node) -> tuple[int, ...]:
        """PEs that `node` may be placed on."""
        pes = self.fabric.hosts(node)
        permitted = self.allowed.get(node.id)
        return pes if permitted is None else tuple(pe for pe in pes if pe in permitted)

    def constants_of(self, node: Node) -> tuple[ConstantKey, ...]:
        """Constant-store entries that `node` occupies on its PE: operands, first words of
        recurrences, and a live-out's own entry.
        """
        return _constants_of(self.dfg)[node.id]

    def release(self, node: Node, pe: int) -> int:
        """The first cycle in which the drain before it lets a node issue on a PE."""
        return self.releases_on(node, (pe,))[0]

    def releases_on(self, node: Node, pes: Iterable[int]) -> list[int]:
        """As `release`, on each of these PEs."""
        if self.drain is None:
            return [0 for _ in pes]
        first = self.drain.accessible_from(node) if node.is_memory else 0
        own = ("live_in", node.name) if node.op is Opcode.LIVE_OUT else None
        writable, readable = self.drain.writable_from, self.drain.readable_from
        held = [(key, writable if key == own else readable) for key in self.constants_of(node)]
        return [max([first, *(since.get((pe, key), 0) for key, since in held)]) for pe in pes]

    def tail(self, node: Node) -> int:
        """Cycles from a node's issue to the end of the region, for what the loop behind it needs
        when it begins.
        """
        fill, tail = self.fill, 0
        if fill is None:
            return 0
        if node.control is not None:
            acts = self.fabric.latency(node) + self.fabric.controller.control_latency
            tail = acts + fill.expected
        if node.is_memory and (after := fill.accessed_after(node)) is not None:
            tail = max(tail, fill.expected - after + 1)
        for key in self.constants_of(node):
            after = fill.after(node, key, self.candidates(node))
            if after is not None:
                tail = max(tail, fill.expected - after + 1)
        return tail

    @cached_property
    def releases(self) -> ReadOnly[int, int]:
        """By node, the first cycle in which the drain lets it issue anywhere; 0: at once."""
        if self.drain is None:
            return {}
        found = (
            (node.id, min(self.releases_on(node, self.candidates(node)), default=0))
            for node in self.dfg.placed
        )
        return {node: cycle for node, cycle in found if cycle}


@once_each
def _constants_of(dfg: DFG) -> dict[int, tuple[ConstantKey, ...]]:
    """`MapProblem.constants_of` of each node."""
    found: dict[int, tuple[ConstantKey, ...]] = {}
    for node in dfg.nodes:
        keys: dict[ConstantKey, None] = {}
        for edge in dfg.in_edges[node.id]:
            for source in (edge.src, edge.init):
                if source is not None and edge.is_data:
                    key = constant_key(dfg.by_id[source])
                    if key is not None:
                        keys[key] = None
        if node.op is Opcode.LIVE_OUT:
            keys[("live_in", node.name)] = None
        found[node.id] = tuple(keys)
    return found


def constant_key(node: Node) -> ConstantKey | None:
    """The constant-store entry that holds a source node's word; None for other nodes and the
    induction value.
    """
    if node.op is Opcode.CONST and node.const is not None:
        return ("const", node.const)
    if node.op is Opcode.LIVE_IN:
        return ("live_in", node.name)
    return None
