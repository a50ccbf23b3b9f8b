"""What a mapper is asked: a DFG, a fabric, and what the rest of the program has already decided."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG, Node
from vividc.machine.opcodes import Opcode

ConstantKey = tuple[str, int | str]
"""An entry of a constant store: ("const", word) or ("live_in", name)."""


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
    """

    dfg: DFG
    fabric: Fabric
    allowed: ReadOnly[int, frozenset[int]] = field(default_factory=dict)
    resident: ReadOnly[int, frozenset[ConstantKey]] = field(default_factory=dict)

    def candidates(self, node: Node) -> tuple[int, ...]:
        """PEs that `node` may be placed on."""
        pes = self.fabric.hosts(node)
        permitted = self.allowed.get(node.id)
        return pes if permitted is None else tuple(pe for pe in pes if pe in permitted)

    def constants_of(self, node: Node) -> tuple[ConstantKey, ...]:
        """Constant-store entries that `node` occupies on its PE: operands, first words of
        recurrences, and a live-out's own entry.
        """
        keys: dict[ConstantKey, None] = {}
        for edge in self.dfg.in_edges[node.id]:
            for source in (edge.src, edge.init):
                if source is not None and edge.is_data:
                    key = constant_key(self.dfg.by_id[source])
                    if key is not None:
                        keys[key] = None
        if node.op is Opcode.LIVE_OUT:
            keys[("live_in", node.name)] = None
        return tuple(keys)


def constant_key(node: Node) -> ConstantKey | None:
    """The constant-store entry that holds a source node's word; None for other nodes and the
    induction value.
    """
    if node.op is Opcode.CONST and node.const is not None:
        return ("const", node.const)
    if node.op is Opcode.LIVE_IN:
        return ("live_in", node.name)
    return None
