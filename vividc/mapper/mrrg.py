"""The modulo routing resource graph of a fabric (MRRG: Mei et al. 2002) as flat arrays.

A *location* is where a word can be for a cycle: the end of a link, or a register file. A *resource*
is what words compete for in a slot: links, registers, ports. Every slot is alike, so the graph is
kept for one of them: node (resource r, slot s) has the number r * II + s, and a move from cycle t
to t + 1 claims in the slots of t and t + 1. The rules are those of `docs/machine.md`; a router that
reads this graph needs no other knowledge of a fabric.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Fabric

Ints = NDArray[np.int64]

NONE: Final = -1
"""No resource."""

Kind = Literal["link", "registers", "read ports", "write ports"]


@dataclass(frozen=True, slots=True)
class Resource:
    """What words compete for: `index` of a link, or of the PE of a register file or its ports;
    `capacity` words a slot.
    """

    kind: Kind
    index: int
    capacity: int


@dataclass(frozen=True, slots=True)
class Rows:
    """A list of int64 for each of n things: row i is items[begin[i] : begin[i + 1]]."""

    begin: Ints
    items: Ints

    @staticmethod
    def of(rows: Iterable[Iterable[int]]) -> Rows:
        """Pack rows of numbers."""
        packed = [list(row) for row in rows]
        begin = np.zeros(len(packed) + 1, dtype=np.int64)
        begin[1:] = np.cumsum([len(row) for row in packed])
        return Rows(begin, np.array([i for row in packed for i in row], dtype=np.int64))

    def __getitem__(self, row: int) -> list[int]:
        """One row."""
        return [int(i) for i in self.items[self.begin[row] : self.begin[row + 1]]]


@dataclass(frozen=True, slots=True)
class MRRG:
    """Where words can be and how they move, for every slot alike.

    Attributes
    ----------
    resources
        All resources; arrays name them by position.
    links
        Locations below this number are links, by link id; the others are register files.
    owner
        PE whose registers a location is, or at which its link ends, int64 (locations,).
    occupies
        Resource that a word takes in every cycle in which it is at the location.
    entering
        Resource that a word takes in the cycle before its first there; NONE: none.
    leaving
        Resource that a word takes in each cycle in which it is read there, by an FU or by another
        location; once however many read it. NONE: none.
    entries
        By PE: locations in which a result can be in the cycle in which it is ready.
    moves
        By location: where a word can be in the cycle after. A location that names itself holds.
    readers
        By location: PEs whose FU or constant store can read it.
    """

    resources: tuple[Resource, ...]
    links: int
    owner: Ints
    occupies: Ints
    entering: Ints
    leaving: Ints
    entries: Rows
    moves: Rows
    readers: Rows

    @property
    def locations(self) -> int:
        """Number of locations."""
        return len(self.owner)

    def claims(self, origin: int, target: int) -> tuple[tuple[int, int], ...]:
        """(resource, 0: the slot of the cycle left, 1: of the cycle entered) of one move; `origin`
        NONE: the result enters `target`.
        """
        if origin == target:
            return ((int(self.occupies[target]), 1),)
        ends = [(int(self.entering[target]), 0), (int(self.occupies[target]), 1)]
        if origin != NONE:
            ends.insert(0, (int(self.leaving[origin]), 0))
        return tuple((resource, when) for resource, when in ends if resource != NONE)


def build_mrrg(fabric: Fabric) -> MRRG:
    """The graph of a fabric. A register file without registers or ports is no location."""
    links = fabric.links
    files = [pe for pe in fabric.pes if pe.registers and pe.read_ports and pe.write_ports]
    resources = [Resource("link", link.id, 1) for link in links]
    resources += [Resource("registers", pe.id, pe.registers) for pe in files]
    resources += [Resource("read ports", pe.id, pe.read_ports) for pe in files]
    resources += [Resource("write ports", pe.id, pe.write_ports) for pe in files]
    first, count = len(links), len(files)
    no_port = [NONE] * first
    owner = [link.dst for link in links] + [pe.id for pe in files]
    file_of = {pe.id: first + number for number, pe in enumerate(files)}
    leads_to = [_onward(fabric, pe.id, file_of) for pe in fabric.pes]
    return MRRG(
        resources=tuple(resources),
        links=first,
        owner=_ints(owner),
        occupies=_ints(range(first + count)),
        entering=_ints(no_port + [first + 2 * count + n for n in range(count)]),
        leaving=_ints(no_port + [first + count + n for n in range(count)]),
        entries=Rows.of(leads_to),
        moves=Rows.of(leads_to[pe] for pe in owner),
        readers=Rows.of([pe] for pe in owner),
    )


def reach(graph: MRRG, pes: int) -> Ints:
    """Least cycles from being ready on one PE to being readable on another, int64 (pes, pes).

    0 on the PE itself and wherever an entry is readable; `1 << 20`: never.
    """
    far = 1 << 20
    found = np.full((pes, pes), far, dtype=np.int64)
    for pe in range(pes):
        frontier = graph.entries[pe]
        seen = set(frontier)
        found[pe, pe] = 0
        cycles = 0
        while frontier:
            for location in frontier:
                for reader in graph.readers[location]:
                    found[pe, reader] = min(found[pe, reader], cycles)
            onward = dict.fromkeys(to for at in frontier for to in graph.moves[at])
            frontier = [to for to in onward if to not in seen]
            seen.update(frontier)
            cycles += 1
    return found


def _onward(fabric: Fabric, pe: int, file_of: dict[int, int]) -> list[int]:
    """Where a word that is readable on `pe` can be in the next cycle."""
    found = [link.id for link in fabric.links_from[pe]]
    return [*found, file_of[pe]] if pe in file_of else found


def _ints(values: Sequence[int]) -> Ints:
    return np.array(values, dtype=np.int64)
