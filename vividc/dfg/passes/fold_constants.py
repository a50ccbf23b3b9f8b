"""Constant folding, and the algebraic identities that hold bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes.identities import IDENTITIES
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation, to_fixpoint
from vividc.machine.opcodes import EXPANDED_FLOATS, MEMORY, PRED, SOURCES, Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import WORD_BITS, signed

_OFFSET_LIMIT: Final = 1 << 15  # what an immediate field of a load/store unit can hold


def fold_constants(dfg: DFG) -> DFG:
    """Evaluate what is constant and simplify what an identity makes simpler.

    Also a constant predicate is resolved, and a constant part of an index goes into the `shift` and
    `offset` of its load or store. Operations that lose their readers stay for `remove_dead_nodes`.
    Floating-point identities are applied only where they keep every bit, NaN payloads included.
    """
    return to_fixpoint(dfg, _fold)


def _fold(rewrite: Rewrite, node: Node) -> bool:
    for rule in _RULES[node.op]:  # noqa: SIM110 - the busiest loop of the passes
        if rule(rewrite, node):
            return True
    return False


def _resolve_predicate(rewrite: Rewrite, node: Node) -> bool:
    edge = rewrite.edge(node.id, PRED)
    if edge is None:
        return False
    word = rewrite.word(Value(edge.src, edge.distance, edge.init))
    if word is None:
        return False
    if word:
        rewrite.remove_edge(edge)
        return True
    if node.op is Opcode.LOAD:
        return rewrite.forward_constant(node.id, 0)
    if node.op not in SEMANTICS:
        return False  # a store that never happens keeps its place among the ORDER edges
    rewrite.remove_edge(edge)
    last = rewrite.operand(node.id, node.info.arity - 1)
    change_operation(rewrite, node, Opcode.MOV, [last])
    return True


def _evaluate(rewrite: Rewrite, node: Node) -> bool:
    """Make an operation on constants a `mov`, which stays where an operation is needed."""
    if rewrite.predicated(node.id):
        return False
    words = []
    for port in range(node.info.arity):
        word = rewrite.word(rewrite.operand(node.id, port))
        if word is None:
            return False
        words.append(word)
    result = Value(rewrite.constant(SEMANTICS[node.op](*words)))
    change_operation(rewrite, node, Opcode.MOV, [result])
    return True


def _apply_identity(rewrite: Rewrite, node: Node) -> bool:
    if rewrite.predicated(node.id):
        return False
    return any(identity(rewrite, node) for identity in IDENTITIES[node.op])


def _fold_index(rewrite: Rewrite, node: Node) -> bool:
    """`x[(i + c) << s]` is offset by c << s; `x[i << k]` is shifted by k more."""
    if rewrite.edge(node.id, 0) is None:
        return False
    index = rewrite.operand(node.id, 0)
    source = rewrite.nodes[index.src]
    if index.distance or source.op not in (Opcode.ADD, Opcode.SHL) or rewrite.predicated(source.id):
        return False
    for port in (1, 0) if source.op is Opcode.ADD else (1,):
        word = rewrite.word(rewrite.operand(source.id, port))
        moved = None if word is None else _with_constant(node, source.op, word)
        if moved is not None:
            rewrite.set_node(moved)
            rewrite.set_operand(node.id, 0, rewrite.operand(source.id, 1 - port))
            return True
    return False


def _with_constant(node: Node, op: Opcode, word: int) -> Node | None:
    if op is Opcode.SHL:
        shift = node.shift + word % WORD_BITS
        return replace(node, shift=shift) if shift < WORD_BITS else None
    offset = node.offset + (signed(word) << node.shift)
    return replace(node, offset=offset) if abs(offset) < _OFFSET_LIMIT else None


_Rule = Callable[[Rewrite, Node], bool]


def _rules_of(op: Opcode) -> Iterator[_Rule]:
    if op in SOURCES:
        return
    yield _resolve_predicate
    if op in SEMANTICS and op not in EXPANDED_FLOATS and op is not Opcode.MOV:
        yield _evaluate
    if op in IDENTITIES:
        yield _apply_identity
    if op in MEMORY:
        yield _fold_index


_RULES: Final[Mapping[Opcode, tuple[_Rule, ...]]] = {op: tuple(_rules_of(op)) for op in Opcode}
