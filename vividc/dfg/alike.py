"""Graphs that differ in the names of their variables, their lines and their addresses only."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from vividc.dfg.ir import DFG, AddressForm, Node
from vividc.host.once import changed
from vividc.machine.opcodes import Opcode

_NAMING = frozenset({Opcode.LIVE_IN, Opcode.LIVE_OUT})

Graph = tuple[DFG, tuple[AddressForm | None, ...]]
"""A graph without a name, and where its accesses go, which makes no other graph of it."""


@dataclass(frozen=True, slots=True)
class Optimized:
    """What the passes made of a region's graph: of it, or of one that differs in the names of its
    variables, its lines and its addresses only.
    """

    source: DFG
    done: DFG
    is_own: bool

    def like(self, other: DFG) -> Optimized | None:
        """What the passes would make of another such graph; None: an access is not found again."""
        renamed = dict(zip(variables(self.source), variables(other), strict=True))
        nodes: list[Node] = []
        for node in self.done.nodes:
            if node.op in _NAMING:
                nodes.append(changed(node, name=renamed.get(node.name, node.name)))
            elif not node.is_memory:
                nodes.append(node)
            elif node.id in other.by_id and other.by_id[node.id].op is node.op:
                nodes.append(changed(node, address=other.by_id[node.id].address))
            else:
                return None
        return Optimized(other, DFG("", tuple(nodes), self.done.edges), False)


def unnamed(dfg: DFG) -> DFG:
    """The graph without its name."""
    return replace(dfg, name="") if dfg.name else dfg  # whose hash is known


def with_addresses(dfg: DFG) -> Graph:
    """The graph without a name, and where its accesses go."""
    return unnamed(dfg), tuple(n.address for n in dfg.nodes if n.is_memory)


def names(dfg: DFG) -> tuple[str, ...]:
    """All names of its variables, in the order of their nodes."""
    return tuple(dict.fromkeys(node.name for node in dfg.nodes if node.op in _NAMING))


def variables(dfg: DFG) -> tuple[str, ...]:
    """The variables that stand for values of a function, in the order of their nodes."""
    return tuple(name for name in names(dfg) if name.startswith("%"))


def numbers(named: Iterable[str]) -> dict[str, str]:
    """Other names by these, which tell their order."""
    return {name: f"%{number}" for number, name in enumerate(named)}


def numbered(dfg: DFG, named: Iterable[str] | None = None) -> DFG:
    """The graph without a name, these variables called by their order; None: those of values."""
    other = numbers(variables(dfg) if named is None else named)
    nodes = (
        changed(node, name=other[node.name]) if node.op in _NAMING and node.name in other else node
        for node in dfg.nodes
    )
    return DFG("", tuple(nodes), dfg.edges)
