"""Where variables live: the PEs whose constant stores hold them between the regions of a kernel.

Loops are mapped first, and what they read or write lives where their operations lie. Any other
variable is free to live where straight regions that read or write it are the shortest for it: a
copy of a word takes as many cycles as its homes are links apart.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.compiler.regions.stores import Homes, Stores
from vividc.dfg.ir import DFG, EdgeKind, Node
from vividc.dfg.order import evaluation_order
from vividc.dfg.regions import RETURN_HIGH, RETURN_VARIABLE, Kernel, is_variable
from vividc.machine.opcodes import Opcode
from vividc.mapper.mapping import Mapping as RegionMapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.distances import hop_distances

_FILLED: Final = 0.5
"""Of the slots of a straight region, at most, by operations: where they take longer than its paths
do, it does not matter how far variables are apart (symm: 497 operations in 50 cycles).
"""


def variable_homes(
    kernel: Kernel,
    fabric: Fabric,
    loops: Mapping[int, RegionMapping],
    entries: Sequence[float] | None = None,
) -> Homes:
    """The PEs whose constant stores hold each variable.

    A variable that loops read or write lives where their operations lie; any other lives on a PE
    with few entries so far: the one that makes straight regions the shortest, each as often as it
    is expected to be entered (`entries`, by region), or else the one with the fewest.
    """
    homes: dict[str, set[int]] = {}
    graphs = [(kernel.regions[index].dfg, mapping) for index, mapping in sorted(loops.items())]
    for dfg, mapping in graphs:
        for node in dfg.placed:
            for kind, name in MapProblem(dfg, fabric).constants_of(node):
                if kind == "live_in" and is_variable(str(name)):
                    homes.setdefault(str(name), set()).add(mapping.places[node.id].pe)
    stores = Stores.of(kernel, fabric).with_regions(graphs)
    ways = _Ways.of_kernel(kernel, fabric, entries)
    for name in _variables_read(kernel):
        if name not in homes:
            load = {pe: stores.load(pe, name) for pe in stores.held}
            pe = _best_home(name, fabric, load, homes, ways)
            homes[name] = {pe}
            stores = stores.with_homes({name: frozenset({pe})})
    return {name: frozenset(pes) for name, pes in homes.items()}


def _best_home(
    name: str,
    fabric: Fabric,
    load: Mapping[int, int],
    homes: Mapping[str, set[int]],
    ways: Sequence[_Ways],
) -> int:
    """Of the PEs whose stores are not half full, or as empty as any."""
    least = min(load.values())
    mine = [region for region in ways if name in region.reads or name in region.writes]
    return min(
        (pe for pe in load if load[pe] <= max(least, fabric.pes[pe].constants // 2)),
        key=lambda pe: (sum(one.cycles(name, pe, homes) for one in mine), load[pe], pe),
    )


@dataclass(frozen=True, slots=True)
class _Way:
    """The longest way of a variable's word to another one's: its cycles, its edges, each of which
    goes a link for nothing, and the other's name.
    """

    cycles: int
    edges: int
    other: str


@dataclass(slots=True)
class _Ways:
    """What a straight region takes at least for where its variables live.

    Attributes
    ----------
    entries
        How often it is entered.
    length
        Cycles of its longest path, or those that its operations take.
    to, of
        By variable that it reads, its ways to those that it writes; the reverse.
    """

    fabric: Fabric
    entries: float
    length: int
    reads: frozenset[str]
    writes: frozenset[str]
    to: dict[str, list[_Way]] = field(default_factory=dict)
    of: dict[str, list[_Way]] = field(default_factory=dict)

    @staticmethod
    def of_kernel(kernel: Kernel, fabric: Fabric, entries: Sequence[float] | None) -> list[_Ways]:
        """Of all straight regions."""
        return [
            _ways(region.dfg, fabric, 1.0 if entries is None else entries[index])
            for index, region in enumerate(kernel.regions)
            if region.kind != "loop"
        ]

    def cycles(self, name: str, pe: int, homes: Mapping[str, set[int]]) -> float:
        """Cycles of a run in the region if a variable lived on a PE."""
        hops, longest = hop_distances(self.fabric), self.length
        beside = sum(homes.get(one) == {pe} for one in self.reads) if name in self.reads else 0
        for way in self.to.get(name, ()):
            far = max((hops[pe][to] for to in homes.get(way.other, ())), default=0)
            longest = max(longest, way.cycles + max(0, far - way.edges) + beside)
        beside = sum(homes.get(one) == {pe} for one in self.writes) if name in self.writes else 0
        for way in self.of.get(name, ()):
            far = min((hops[at][pe] for at in homes.get(way.other, ())), default=0)
            longest = max(longest, way.cycles + max(0, far - way.edges) + beside)
        return self.entries * longest


def _ways(dfg: DFG, fabric: Fabric, entries: float) -> _Ways:
    reads = [n for n in dfg.nodes if n.op is Opcode.LIVE_IN and is_variable(n.name)]
    writes = [n for n in dfg.nodes if n.op is Opcode.LIVE_OUT]
    ways = _Ways(
        fabric, entries, 0, frozenset(n.name for n in reads), frozenset(n.name for n in writes)
    )
    ways.length = math.ceil(len(dfg.operations) / (_FILLED * len(fabric.pes)))
    order = evaluation_order(dfg)
    for read in reads:
        starts = _starts(dfg, fabric, order, read.id)
        ways.length = max(ways.length, *(cycles + 1 for cycles, _ in starts.values()))
        for write in writes:
            if write.id in starts:
                cycles, edges = starts[write.id]
                ways.to.setdefault(read.name, []).append(_Way(cycles + 1, edges, write.name))
                ways.of.setdefault(write.name, []).append(_Way(cycles + 1, edges, read.name))
    return ways


def _starts(
    dfg: DFG, fabric: Fabric, order: Sequence[int], read: int
) -> dict[int, tuple[int, int]]:
    """The earliest start of each node that a variable's word leads to, and the edges on the way,
    from the `mov` that reads it on.
    """
    starts, mov = {read: (0, 0)}, fabric.latency(Node(0, Opcode.MOV))
    for ident in order:
        if ident not in starts:
            continue
        cycles, edges = starts[ident]
        node = dfg.by_id[ident]
        for edge in dfg.out_edges[ident]:
            after = (cycles + fabric.latency(node), edges + 1)
            if ident == read:
                is_mov = dfg.by_id[edge.dst].op is Opcode.MOV
                after = (0, 0) if is_mov else (mov, 1)
            elif edge.kind is EdgeKind.ORDER:
                after = (cycles + 1, edges + 1)
            elif edge.kind is EdgeKind.CONTROL:
                after = (after[0] + fabric.controller.control_latency, edges + 1)
            starts[edge.dst] = max(starts.get(edge.dst, after), after)
    return starts


def _variables_read(kernel: Kernel) -> list[str]:
    names = dict.fromkeys(
        node.name
        for region in kernel.regions
        for node in region.dfg.nodes
        if node.op is Opcode.LIVE_IN and is_variable(node.name)
    )
    if kernel.returns is not None:
        written = {n.name for r in kernel.regions for n in r.dfg.nodes if n.op is Opcode.LIVE_OUT}
        names.update((name, None) for name in (RETURN_VARIABLE, RETURN_HIGH) if name in written)
    return list(names)
