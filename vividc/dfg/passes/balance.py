"""Balancing of reductions: a chain of one associative operation becomes a tree."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import networkx as nx

from vividc.dfg.ir import DFG, Node
from vividc.dfg.order import evaluation_order
from vividc.dfg.passes.fused_sums import fused_sums
from vividc.dfg.passes.rewrite import Rewrite, Value
from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode

EXACT: Final = frozenset(
    {Opcode.ADD, Opcode.MUL, Opcode.AND, Opcode.OR, Opcode.XOR, Opcode.SMIN, Opcode.SMAX}
)
"""Associative and commutative bit for bit."""

REASSOCIATED: Final = EXACT | {Opcode.FADD, Opcode.FMUL}
"""With those that round differently in another order."""

_LEAVES_THAT_HAVE_AN_ORDER: Final = 3


def balance_reductions(dfg: DFG, *, reassociate: bool = False) -> DFG:
    """Combines operands that are ready early first, and what the last iteration left last of all.

    In a loop only what the last iteration left counts: a lower tree would need its words at once,
    and start no iteration earlier. A sum of an accumulator and n words then has a recurrence of one
    addition instead of n, and elsewhere a sum of n words the height of a tree (Kuck 1978). Partial
    results that others read stay.

    Parameters
    ----------
    reassociate
        Also float additions and multiplications, and sums of products that are fused with them,
        whose rounding changes.
    """
    operations = REASSOCIATED if reassociate else EXACT
    before = None
    while dfg is not before:  # a tree that is ready earlier may change the order in another
        before, dfg = dfg, _balance_once(dfg, operations)
    if reassociate:
        dfg = fused_sums(dfg, _levels(dfg), _components(dfg), in_loop=_is_loop(dfg))
    return dfg


def rebalance_sums_of_loops(dfg: DFG) -> DFG:
    """Float sums with fused products in an order that is done sooner, whose rounding changes: again
    when predicates say which products are added. Straight code has no registers to spare for it
    (544 operations of symm).
    """
    if not _is_loop(dfg):
        return dfg
    return fused_sums(dfg, _levels(dfg), _components(dfg), in_loop=True)


def pass_for(*, reassociate: bool) -> partial[DFG]:
    """`balance_reductions` with its option set, under its own name."""
    step = partial(balance_reductions, reassociate=reassociate)
    step.__name__ = balance_reductions.__name__  # type: ignore[attr-defined]
    return step


def _balance_once(dfg: DFG, operations: frozenset[Opcode]) -> DFG:
    rewrite = Rewrite(dfg)
    in_loop = _is_loop(dfg)
    for node in dfg.nodes:
        if node.op in operations and not rewrite.predicated(node.id):
            tree = _Tree(rewrite, node, dfg)
            tree.collect()
            if len(tree.leaves) < _LEAVES_THAT_HAVE_AN_ORDER:
                continue
            if not in_loop or tree.is_recurrent:
                tree.balance()
    return rewrite.result()


def _is_loop(dfg: DFG) -> bool:
    is_carried = any(edge.distance for edge in dfg.edges)
    return is_carried or any(node.op is Opcode.IV for node in dfg.nodes)


@dataclass
class _Tree:
    """The operations below `root` that only feed it, and what they combine."""

    rewrite: Rewrite
    root: Node
    before: DFG
    inner: list[int] = field(default_factory=list)
    leaves: list[Value] = field(default_factory=list)
    depths: list[int] = field(default_factory=list)

    def collect(self) -> None:
        """Finds leaves with their depths; nothing if the root feeds a larger tree."""
        if not self._is_inner(self.root.id, self.root.op):
            self._descend(self.root.id, 1)

    @property
    def is_recurrent(self) -> bool:
        """Whether a leaf needs what the root gave before."""
        component = _components(self.before)
        own = component[self.root.id]
        return any(component[leaf.src] == own for leaf in self.leaves)

    def balance(self) -> None:
        """Rewires the operations if that shortens the way of the latest leaf."""
        ready = [self._ready(leaf) for leaf in self.leaves]
        now = max(level + depth for level, depth in zip(ready, self.depths, strict=True))
        heap = [(ready[order], order, leaf) for order, leaf in enumerate(self.leaves)]
        heapq.heapify(heap)
        pairs: list[tuple[int, Value, Value]] = []
        targets = [*reversed(self.inner), self.root.id]
        for number, target in enumerate(targets):
            one, other = heapq.heappop(heap), heapq.heappop(heap)
            pairs.append((target, one[2], other[2]))
            level = max(one[0], other[0]) + 1
            heapq.heappush(heap, (level, len(ready) + number, Value(target)))
        if heap[0][0] >= now:
            return
        for target, one_value, other_value in pairs:
            self.rewrite.set_operand(target, 0, one_value)
            self.rewrite.set_operand(target, 1, other_value)

    def _descend(self, node_id: int, depth: int) -> None:
        for value in self.rewrite.operands(self.rewrite.nodes[node_id]):
            source = value.src
            if value.distance == 0 and self._is_inner(source, self.root.op):
                self.inner.append(source)
                self._descend(source, depth + 1)
            else:
                self.leaves.append(value)
                self.depths.append(depth)

    def _is_inner(self, node_id: int, op: Opcode) -> bool:
        """Whether the node feeds another of its kind in this iteration and nothing else."""
        node = self.rewrite.nodes[node_id]
        uses = self.rewrite.uses(node_id)
        if node.op is not op or node.control is not None or len(uses) != 1:
            return False
        reader = self.rewrite.nodes[uses[0].dst]
        if uses[0].distance or reader.op is not op or uses[0].port not in (0, 1):
            return False
        return not self.rewrite.predicated(node_id) and not self.rewrite.predicated(reader.id)

    def _ready(self, leaf: Value) -> int:
        """When a leaf is there, in operations; later than all others if it needs the last root."""
        level, component = _levels(self.before), _components(self.before)
        if component[leaf.src] == component[self.root.id]:
            return len(level) + level[leaf.src] * (leaf.distance == 0)
        return level[leaf.src] if leaf.distance == 0 else 0


@once_each
def _levels(dfg: DFG) -> dict[int, int]:
    """Operations on the longest path to each node within an iteration, itself included."""
    levels: dict[int, int] = {}
    for node_id in evaluation_order(dfg):
        before = (levels[e.src] for e in dfg.in_edges[node_id] if e.is_data and not e.distance)
        own = 0 if dfg.by_id[node_id].is_source else 1
        levels[node_id] = max(before, default=0) + own
    return levels


@once_each
def _components(dfg: DFG) -> dict[int, int]:
    """The recurrence each node is in, by number; nodes in none have one of their own."""
    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(node.id for node in dfg.nodes)
    graph.add_edges_from((edge.src, edge.dst) for edge in dfg.edges if edge.is_data)
    parts = enumerate(nx.strongly_connected_components(graph))
    return {node_id: number for number, nodes in parts for node_id in nodes}
