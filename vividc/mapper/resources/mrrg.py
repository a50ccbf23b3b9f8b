"""The modulo routing resource graph of a fabric (MRRG: Mei et al. 2002) as flat arrays.

A *location* is where a word can be for a cycle: the end of a link, a register file, or an output
register. A *resource* is what words compete for in a slot: links, registers, ports, and where
output registers take part in routes those and the FUs. Every slot is alike, so the graph is kept
for one of them: node (resource r, slot s) has the number r * II + s, and a move from cycle t to t +
1 claims in the slots of t and t + 1. The rules are those of `docs/machine.md`; a router that reads
this graph needs no other knowledge of a fabric.

Where a word may pass several links in a cycle, a link is a location for each place it can have
among those of the cycle. An output register is two locations: one for the cycle in which a result
or a moved word enters it, one for all later cycles.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np

from vividc.arch.fabric import Fabric
from vividc.host.once import once_each
from vividc.mapper.resources.arrays import Bytes, Ints, Rows
from vividc.mapper.resources.distances import FAR

NONE: Final = -1
"""No resource."""

Kind = Literal["link", "registers", "read ports", "write ports", "output", "FU"]


@dataclass(frozen=True, slots=True)
class Resource:
    """What words compete for: `index` of a link, or of the PE of a register file or its ports;
    `capacity` words a slot.
    """

    kind: Kind
    index: int
    capacity: int


@dataclass(frozen=True, slots=True)
class Spot:
    """What a location is: the end of link `index`, or the register file or output register of PE
    `index`.
    """

    kind: Literal["link", "reg", "out"]
    index: int


@dataclass(frozen=True)
class MRRG:
    """Where words can be and how they move, for every slot alike.

    Attributes
    ----------
    resources
        All resources; arrays name them by position.
    links
        Locations below this number are links, the others register files and output registers.
        `spots` says which.
    spots
        By location: what it is.
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
        By location: where a word can be in the cycle after.
    keeps
        By location: a word that is there in the cycle after, too, needs no more than the place,
        uint8 (locations,).
    sides
        By location: where a word that came there from elsewhere can be in the same cycle, too.
    aside
        By location: words come there only in these ways, uint8 (locations,): as results, from a
        location that has it among its `sides`, or by staying.
    readers
        By location: PEs whose FU or constant store can read it.
    fresh
        By PE: the location that each result enters by itself, which is its output register in its
        first cycle; NONE: no output register takes part in routes.
    """

    resources: tuple[Resource, ...]
    links: int
    spots: tuple[Spot, ...]
    owner: Ints
    occupies: Ints
    entering: Ints
    leaving: Ints
    entries: Rows
    moves: Rows
    keeps: Bytes
    sides: Rows
    aside: Bytes
    readers: Rows
    fresh: Ints

    @property
    def locations(self) -> int:
        """Number of locations."""
        return len(self.owner)

    @cached_property
    def away(self) -> Ints:
        """Least cycles from being at each location to being readable on each PE, int64 (locations,
        PEs); `FAR`: never.
        """
        cycles = np.full((self.locations, len(self.fresh)), FAR, dtype=np.int64)
        for location in range(self.locations):
            cycles[location, self.readers[location]] = 0
        ways = [(self.moves[at], self.sides[at]) for at in range(self.locations)]
        changed = True
        while changed:
            changed = False
            for location in reversed(range(self.locations)):
                onward, beside = ways[location]
                best = cycles[location]
                if onward:
                    best = np.minimum(best, cycles[onward].min(axis=0) + 1)
                if beside:
                    best = np.minimum(best, cycles[beside].min(axis=0))
                if (best < cycles[location]).any():
                    cycles[location] = best
                    changed = True
        return np.minimum(cycles, FAR)

    @cached_property
    def reach(self) -> Ints:
        """Least cycles from being ready on one PE to being readable on another, int64 (PEs, PEs).

        0 on the PE itself and wherever an entry is readable; `FAR`: never.
        """
        pes = len(self.fresh)
        cycles = np.full((pes, pes), FAR, dtype=np.int64)
        for pe in range(pes):
            if self.entries[pe]:
                cycles[pe] = self.away[self.entries[pe]].min(axis=0)
            cycles[pe, pe] = 0
        return cycles

    def claims(self, origin: int, target: int) -> tuple[tuple[int, int], ...]:
        """(resource, 0: the slot of the cycle left, 1: of the cycle entered) of one move; `origin`
        NONE: the result enters `target`.
        """
        if origin == target and self.keeps[target]:
            return ((int(self.occupies[target]), 1),)
        ends = [(int(self.entering[target]), 0), (int(self.occupies[target]), 1)]
        if origin != NONE:
            ends.insert(0, (int(self.leaving[origin]), 0))
        return tuple((resource, when) for resource, when in ends if resource != NONE)


@once_each
def build_mrrg(fabric: Fabric) -> MRRG:
    """The graph of a fabric. A register file without registers or ports is no location.

    Rotating files are taken for ones whose registers keep their names, and FUs for pipelined.
    """
    return _Builder(fabric).build()


class _Builder:
    """Numbers of locations and resources. Locations in the order in which a word can come to them
    within a cycle: links by depth, output registers, register files.
    """

    def __init__(self, fabric: Fabric) -> None:
        routing = fabric.routing
        self.fabric = fabric
        self.pes = len(fabric.pes)
        self.files = [
            pe.id for pe in fabric.pes if pe.registers and pe.read_ports and pe.write_ports
        ]
        self.wires = len(fabric.links) if routing.hops else 0
        self.links = self.wires * max(routing.hops, 1)
        self.outs = self.pes if routing.open_outputs else 0
        self.first_held = self.links + self.outs
        first_file = self.first_held + (self.outs if routing.holds else 0)
        self.file_of = {pe: first_file + number for number, pe in enumerate(self.files)}
        self.locations = first_file + len(self.files)

    def build(self) -> MRRG:
        spots = self._spots()
        owner = [
            self.fabric.links[spot.index].dst if spot.kind == "link" else spot.index
            for spot in spots
        ]
        first, count = self.wires, len(self.files)
        first_out = first + 3 * count
        number = {pe: at for at, pe in enumerate(self.files)}
        takes = [
            {"link": 0, "reg": first, "out": first_out}[spot.kind]
            + (number[spot.index] if spot.kind == "reg" else spot.index)
            for spot in spots
        ]
        files = range(self.locations - count, self.locations)
        entering = np.full(self.locations, NONE, dtype=np.int64)
        leaving = entering.copy()
        entering[list(files)] = range(first + 2 * count, first + 3 * count)
        leaving[list(files)] = range(first + count, first + 2 * count)
        for pe in range(self.outs):
            entering[self.links + pe] = first_out + self.outs + pe
        aside = [spot.kind == "link" and at >= self.wires for at, spot in enumerate(spots)]
        for pe, file in self.file_of.items():
            aside[file] = self._enters_with_result(pe)
        return MRRG(
            resources=self._resources(),
            links=self.links,
            spots=spots,
            owner=_ints(owner),
            occupies=_ints(takes),
            entering=entering,
            leaving=leaving,
            entries=Rows.of(self._entries(pe) for pe in range(self.pes)),
            moves=Rows.of(self._moves(at) for at in range(self.locations)),
            keeps=_bits(at >= self.first_held for at in range(self.locations)),
            sides=Rows.of(self._sides(at, spot) for at, spot in enumerate(spots)),
            aside=_bits(aside),
            readers=Rows.of(self._readers(at) for at in range(self.locations)),
            fresh=_ints(self.links + pe if self.outs else NONE for pe in range(self.pes)),
        )

    def _spots(self) -> tuple[Spot, ...]:
        spots = [Spot("link", at % self.wires) for at in range(self.links)]
        outs = [Spot("out", pe) for pe in range(self.outs)]
        spots += outs * (2 if self.fabric.routing.holds else 1)
        return (*spots, *(Spot("reg", pe) for pe in self.files))

    def _resources(self) -> tuple[Resource, ...]:
        pes = [self.fabric.pes[pe] for pe in self.files]
        return (
            *(Resource("link", link, 1) for link in range(self.wires)),
            *(Resource("registers", pe.id, pe.registers) for pe in pes),
            *(Resource("read ports", pe.id, pe.read_ports) for pe in pes),
            *(Resource("write ports", pe.id, pe.write_ports) for pe in pes),
            *(Resource("output", pe, 1) for pe in range(self.outs)),
            *(Resource("FU", pe, 1) for pe in range(self.outs)),
        )

    def _enters_with_result(self, pe: int) -> bool:
        """Words enter the register file of a PE only as results of its FU."""
        return self.fabric.pes[pe].written_by_fu

    def _entries(self, pe: int) -> list[int]:
        entries = [link.id for link in self.fabric.links_from[pe] if link.id < self.wires]
        entries += [self.links + pe] if self.outs else []
        return [*entries, self.file_of[pe]] if pe in self.file_of else entries

    def _moves(self, at: int) -> list[int]:
        """Links, outputs and files of the PEs that read the location, and the location itself or
        the output register it becomes, where it keeps words.
        """
        targets: dict[int, None] = {}
        for pe in self._readers(at):
            targets |= dict.fromkeys(
                link.id for link in self.fabric.links_from[pe] if link.id < self.wires
            )
            if self.fabric.routing.moves:
                targets[self.links + pe] = None
            if pe in self.file_of and not self._enters_with_result(pe):
                targets[self.file_of[pe]] = None
        if at in self.file_of.values():
            targets[at] = None
        elif at >= self.links and self.fabric.routing.holds:
            pe = (at - self.links) % self.pes
            targets[self.first_held + pe] = None
        return list(targets)

    def _sides(self, at: int, spot: Spot) -> list[int]:
        if spot.kind == "link":
            below = at - spot.index + self.wires
            if below >= self.links:
                return []
            end = self.fabric.links[spot.index].dst
            return [below + link.id for link in self.fabric.links_from[end]]
        if spot.kind == "out" and at < self.first_held:
            pe = spot.index
            return [self.file_of[pe]] if pe in self.file_of and self._enters_with_result(pe) else []
        return []

    def _readers(self, at: int) -> list[int]:
        if at < self.links:
            return [self.fabric.links[at % self.wires].dst]
        if at >= self.locations - len(self.files):
            return [self.files[at - self.locations + len(self.files)]]
        pe = (at - self.links) % self.pes
        return [reader for reader, seen in enumerate(self.fabric.outputs_seen_by) if pe in seen]


def _bits(values: Iterable[bool]) -> Bytes:
    return np.array(list(values), dtype=np.uint8)


def _ints(values: Iterable[int]) -> Ints:
    return np.array(list(values), dtype=np.int64)
