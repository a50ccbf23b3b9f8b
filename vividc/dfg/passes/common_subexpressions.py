"""Common-subexpression elimination."""

from __future__ import annotations

from collections.abc import Hashable

from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.order import evaluation_order
from vividc.dfg.passes.rewrite import Rewrite, Value, value_of
from vividc.machine.opcodes import BASE, PRED, Opcode
from vividc.machine.semantics import SEMANTICS


def eliminate_common_subexpressions(dfg: DFG) -> DFG:
    """Merge nodes that compute the same word in every iteration; the first one's source line stays.

    Loads are merged only where the graph neither stores to their array nor orders them. A node that
    the controller reads is never removed, but others may be merged into it.
    """
    stored = {node.name for node in dfg.nodes if node.op is Opcode.STORE}
    rewrite = Rewrite(dfg)
    again = True
    while again:  # merging operands over a recurrence can make earlier nodes equal
        again = _merge_once(rewrite, stored)
    return rewrite.result()


def _merge_once(rewrite: Rewrite, stored: set[str]) -> bool:
    first: dict[Hashable, int] = {}
    changed = False
    for node_id in _candidates(rewrite):
        node = rewrite.nodes[node_id]
        key = _key(rewrite, node, stored)
        if key is None:
            continue
        kept = first.setdefault(key, node_id)
        if kept != node_id and node.control is None:
            _merge(rewrite, node, kept)
            changed = True
    return changed


def _candidates(rewrite: Rewrite) -> list[int]:
    """Evaluation order, but nodes with a control mark first, so that others merge into them."""
    order = evaluation_order(rewrite.result())
    return sorted(order, key=lambda node_id: rewrite.nodes[node_id].control is None)


def _key(rewrite: Rewrite, node: Node, stored: set[str]) -> Hashable | None:
    """What the node's word depends on; None if it may not be merged."""
    if node.is_source:
        return node.op, node.const, node.name
    if node.op is Opcode.LOAD:
        if node.name in stored or any(not edge.is_data for edge in _edges(rewrite, node.id)):
            return None
    elif node.op not in SEMANTICS:
        return None
    operands: list[Hashable] = [_read(rewrite, node, port) for port in range(node.info.arity)]
    pred, base = _read(rewrite, node, PRED), _read(rewrite, node, BASE)
    if node.info.commutes and pred is None:  # a predicate decides which operand passes through
        operands[:2] = [frozenset(operands[:2])]
    address = (node.name, node.shift, node.offset, node.width, node.signed)
    return node.op, address, tuple(operands), pred, base


def _edges(rewrite: Rewrite, node_id: int) -> list[Edge]:
    return [*rewrite.in_edges(node_id), *rewrite.out_edges(node_id)]


def _read(rewrite: Rewrite, node: Node, port: int) -> Value | None:
    edge = rewrite.edge(node.id, port)
    return None if edge is None else value_of(edge)


def _merge(rewrite: Rewrite, node: Node, kept: int) -> None:
    if node.is_source:
        rewrite.replace_init(node.id, kept)
    rewrite.forward(node.id, Value(kept))
    assert not rewrite.uses(node.id), "equal operations can be read alike"
    rewrite.remove_node(node.id)
