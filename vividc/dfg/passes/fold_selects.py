"""Folding of a select into the predicate of the operation that it guards."""

from __future__ import annotations

from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, to_fixpoint
from vividc.machine.compare import INVERSES, is_comparison
from vividc.machine.opcodes import ELEMENTARY, PRED, Opcode, Type
from vividc.machine.semantics import SEMANTICS


def fold_selects(dfg: DFG) -> DFG:
    """Turn `select(p, op(.., x), x)` into `op(.., x)` predicated by p, which passes x through.

    An operation with other readers is copied if x is the select's own earlier word, which takes the
    select out of that recurrence at no cost in operations; else it must have no other reader.
    Operands of a commuting one are swapped to bring x last. `select(p, x, op(.., x))` needs the
    inverse predicate: the inverse comparison, or `p xor 1`. That costs one operation, shared by all
    selects of p, and saves at least one. Where the predicate itself depends on the select over a
    recurrence, the fold must not make that recurrence longer; see `_keeps_recurrence`.
    """
    return to_fixpoint(dfg, _fold)


def _fold(rewrite: Rewrite, node: Node) -> bool:
    if node.op is not Opcode.SELECT or rewrite.predicated(node.id) or node.control is not None:
        return False
    pred, if_true, if_false = rewrite.operands(node)
    for guarded, kept, inverted in ((if_true, if_false, False), (if_false, if_true, True)):
        operation = _guarded(rewrite, guarded, kept, copies=kept.src == node.id)
        if operation is None or not _keeps_recurrence(rewrite, node, pred, kept):
            continue
        if not rewrite.can_forward(node.id, guarded):
            continue
        compared = is_comparison(rewrite.nodes[pred.src].op)
        if inverted and not compared and _depends(rewrite, pred.src, node.id):
            continue  # the inversion would lengthen the recurrence through the predicate
        if len(rewrite.uses(operation.id)) != 1:
            operation = rewrite.nodes[
                rewrite.add_node(
                    operation.op, rewrite.operands(operation), operation.loc, operation.lane
                )
            ]
        _predicate(rewrite, operation, _inverse(rewrite, pred) if inverted else pred, kept)
        rewrite.forward(node.id, Value(operation.id))
        rewrite.remove_node(node.id)
        return True
    return False


def _guarded(rewrite: Rewrite, value: Value, kept: Value, *, copies: bool) -> Node | None:
    """The operation that `value` reads, if it (or a copy of it) can pass `kept` through instead."""
    source = rewrite.nodes[value.src]
    if value.distance or source.op not in SEMANTICS or source.control is not None:
        return None
    if rewrite.predicated(source.id) or (len(rewrite.uses(source.id)) != 1 and not copies):
        return None
    if source.info.result is Type.PRED or source.op in ELEMENTARY:
        return None  # a predicate does not pass a compared operand on
    operands = rewrite.operands(source)
    if operands[-1] == kept:
        return source
    binary = len(operands) == 2  # noqa: PLR2004 - ports 0 and 1 commute, so x must be one of them
    return source if binary and source.info.commutes and operands[0] == kept else None


def _keeps_recurrence(rewrite: Rewrite, select: Node, pred: Value, kept: Value) -> bool:
    """Whether no recurrence through the predicate grows by more than the select that goes away.

    The predicate now has to wait for the operation, not for the select. That is harmless if it does
    not depend on the select at all, or if it is one comparison of the very word that the operation
    reads.
    """
    if not _depends(rewrite, pred.src, select.id):
        return True
    comparison = rewrite.nodes[pred.src]
    if not is_comparison(comparison.op) or kept.src != select.id:
        return False
    sources = {value.src for value in rewrite.operands(comparison)} - {select.id}
    return not any(_depends(rewrite, source, select.id) for source in sources)


def _depends(rewrite: Rewrite, node_id: int, on: int) -> bool:
    """Whether a path of data edges, of any distance, leads from `on` to the node."""
    pending = [node_id]
    seen = {node_id}
    while pending:
        current = pending.pop()
        if current == on:
            return True
        for edge in rewrite.in_edges(current):
            if edge.is_data and edge.src not in seen:
                seen.add(edge.src)
                pending.append(edge.src)
    return False


def _inverse(rewrite: Rewrite, pred: Value) -> Value:
    source = rewrite.nodes[pred.src]
    known = source.op in INVERSES and not pred.distance and not rewrite.predicated(source.id)
    if not known:
        one = Value(rewrite.constant(1))
        return Value(_operation(rewrite, Opcode.XOR, [pred, one], source))
    op, swapped = INVERSES[source.op]
    operands = rewrite.operands(source)
    return Value(_operation(rewrite, op, operands[::-1] if swapped else operands, source))


def _operation(rewrite: Rewrite, op: Opcode, operands: list[Value], like: Node) -> int:
    """An operation on these operands, an existing one if there is."""
    for edge in rewrite.uses(operands[0].src):
        node = rewrite.nodes[edge.dst]
        if node.op is not op or rewrite.predicated(node.id):
            continue
        if rewrite.operands(node) == operands:
            return node.id
    return rewrite.add_node(op, operands, like.loc, like.lane)


def _predicate(rewrite: Rewrite, operation: Node, pred: Value, kept: Value) -> None:
    operands = rewrite.operands(operation)
    if operands[-1] != kept:
        rewrite.set_operand(operation.id, 0, operands[1])
        rewrite.set_operand(operation.id, 1, operands[0])
    rewrite.add_edge(Edge(pred.src, operation.id, PRED, pred.distance, pred.init))
