"""The fabric a program runs on, as data: PEs, links, latencies, scratchpad, controller.

`docs/machine.md` gives the timing rules that these parameters feed; nothing here is an algorithm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from vividc.dfg.ir import Node
from vividc.machine.opcodes import LatencyClass, OpInfo


@dataclass(frozen=True, slots=True)
class PE:
    """One processing element.

    Attributes
    ----------
    id
        Row-major index.
    row, col
        Position, row 0 in the north.
    classes
        Latency classes its FU executes (`LOAD` and `STORE`: it has a load/store unit).
    registers, read_ports, write_ports
        Size and ports of its register file.
    constants
        Entries of its constant store.
    rotating
        Its registers are renamed at every iteration: each iteration writes its own.
    written_by_fu
        Its registers take the FU's result only, not what the crossbar carries.
    sliced
        Its float unit is made of slices: what it does with FP32 it does with two FP16 or four FP8
        numbers, too.
    """

    id: int
    row: int
    col: int
    classes: frozenset[LatencyClass]
    registers: int
    read_ports: int
    write_ports: int
    constants: int
    rotating: bool = False
    written_by_fu: bool = False
    sliced: bool = True

    def executes(self, op: OpInfo) -> bool:
        """Whether its FU, or its load/store unit, has an operation."""
        return op.latency_class in self.classes and (self.sliced or not op.sliced)

    @property
    def has_memory(self) -> bool:
        """Has a load/store unit."""
        return LatencyClass.LOAD in self.classes


@dataclass(frozen=True, slots=True)
class Link:
    """A registered one-word link from PE `src` to PE `dst`; `id` is its index in `Fabric.links`."""

    id: int
    src: int
    dst: int


@dataclass(frozen=True, slots=True)
class Routing:
    """How words travel (docs/machine.md); the defaults are ViViD's.

    Attributes
    ----------
    hops
        Links that a word may pass in one cycle. 0: links carry no words; they only say whose output
        register a PE can read.
    holds
        An output register keeps its word until the next operation of its PE completes, else for
        one cycle.
    shared
        The PEs at the ends of a PE's links read its output register, too.
    moves
        An FU may pass a word on: an operation of one cycle, whatever the latencies are.
    """

    hops: int = 1
    holds: bool = False
    shared: bool = False
    moves: bool = False

    @property
    def open_outputs(self) -> bool:
        """Output registers are more than the FU's own last result: routes lead through them, and
        the crossbar takes words from them.
        """
        return self.holds or self.shared or self.moves


@dataclass(frozen=True, slots=True)
class Scratchpad:
    """A tile's memory: word-interleaved `banks`, each with one access a cycle."""

    size_bytes: int
    banks: int

    @property
    def words(self) -> int:
        """Capacity in 32-bit words."""
        return self.size_bytes // 4

    def may_meet(self, gap_bytes: int) -> bool:
        """Whether two accesses `gap_bytes` apart can be in one bank: in words that are a multiple
        of `banks` apart, for some alignment of the first.
        """
        around = 4 * self.banks
        return min(gap_bytes % around, -gap_bytes % around) < 4  # noqa: PLR2004 - a word's bytes


@dataclass(frozen=True, slots=True)
class Controller:
    """The tile controller.

    Attributes
    ----------
    contexts
        Configuration words per PE: the sum of the regions' II may not exceed it.
    control_latency
        Cycles from a control result being ready to its effect on issue.
    switch_cycles
        Cycles between the last cycle of a region and the first of the next.
    max_stages
        Stage-valid bits: a loop's schedule may span this many stages.
    """

    contexts: int
    control_latency: int
    switch_cycles: int
    max_stages: int


@dataclass(frozen=True)
class Fabric:
    """One tile, built by `vividc.arch.load`; `source` is its YAML text (provenance).

    `occupancies`: cycles for which an operation of a class keeps its FU; 1 where nothing is said.
    """

    name: str
    rows: int
    cols: int
    pes: tuple[PE, ...]
    links: tuple[Link, ...]
    latencies: Mapping[LatencyClass, int]
    scratchpad: Scratchpad
    controller: Controller
    clock_ghz: float
    source: str = ""
    routing: Routing = Routing()
    occupancies: Mapping[LatencyClass, int] = field(default_factory=dict)

    def __repr__(self) -> str:
        pad = self.scratchpad
        memory = f"{pad.size_bytes} bytes in {pad.banks} banks"
        return f"<Fabric {self.name}: {self.rows}x{self.cols} PEs, {memory}>"

    def latency(self, node: Node) -> int:
        """Cycles from issue of `node` to its result: 1 or more; 0 for sources and sinks."""
        return self.latencies[node.latency_class]

    def occupancy(self, node: Node) -> int:
        """Cycles from the issue of `node` in which its FU can issue nothing else, the first
        included; 1: pipelined.
        """
        return self.occupancies.get(node.latency_class, 1)

    def supports(self, pe: int, node: Node) -> bool:
        """Whether `node` may be placed on `pe`. A live-out may lie on every PE."""
        return self._runs(self.pes[pe], node.latency_class, sliced=node.info.sliced)

    def hosts(self, node: Node) -> tuple[int, ...]:
        """The PEs that support `node`, ascending."""
        return self._hosts[node.latency_class, node.info.sliced]

    @cached_property
    def _hosts(self) -> Mapping[tuple[LatencyClass, bool], tuple[int, ...]]:
        return {
            (kind, sliced): tuple(pe.id for pe in self.pes if self._runs(pe, kind, sliced=sliced))
            for kind in LatencyClass
            for sliced in (False, True)
        }

    @staticmethod
    def _runs(pe: PE, kind: LatencyClass, *, sliced: bool) -> bool:
        if kind is LatencyClass.SINK:
            return True
        return kind in pe.classes and (pe.sliced or not sliced)

    @cached_property
    def links_from(self) -> tuple[tuple[Link, ...], ...]:
        """Outgoing links of each PE, by link id."""
        return tuple(tuple(k for k in self.links if k.src == pe.id) for pe in self.pes)

    @cached_property
    def outputs_seen_by(self) -> tuple[tuple[int, ...], ...]:
        """For each PE the PEs whose output register it reads, itself first."""
        return tuple(
            (pe.id, *(k.src for k in self.links_to[pe.id] if self.routing.shared))
            for pe in self.pes
        )

    @property
    def is_plain(self) -> bool:
        """Whether words travel and FUs work as in ViViD, the defaults of every option."""
        files = any(pe.rotating or pe.written_by_fu for pe in self.pes)
        busy = any(cycles > 1 for cycles in self.occupancies.values())
        return self.routing == Routing() and not files and not busy

    @cached_property
    def links_to(self) -> tuple[tuple[Link, ...], ...]:
        """Incoming links of each PE, by link id."""
        return tuple(tuple(k for k in self.links if k.dst == pe.id) for pe in self.pes)
