"""Contraction of a multiplication and an addition into one fused operation."""

from __future__ import annotations

from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation, to_fixpoint
from vividc.machine.opcodes import PRED, Opcode
from vividc.machine.words import SIGN_BIT


def contract_fma(dfg: DFG) -> DFG:
    """Turn `a*b + c`, `a*b - c` and `c - a*b` into one `fma`, which rounds once instead of twice.

    The product must have no other reader. The subtractions need a negated operand, and are
    contracted only where that is free: a constant, or an existing `fneg`. A predicated addition is
    contracted only if it passes `c` through, as the `fma` will.
    """
    return to_fixpoint(dfg, _contract)


def _contract(rewrite: Rewrite, node: Node) -> bool:
    if node.op not in (Opcode.FADD, Opcode.FSUB):
        return False
    return any(_contract_port(rewrite, node, port) for port in (0, 1))


def _contract_port(rewrite: Rewrite, node: Node, port: int) -> bool:
    """Contract with the product that `port` reads."""
    product = _product(rewrite, rewrite.operand(node.id, port))
    if product is None:
        return False
    if port == 1 and rewrite.edge(node.id, PRED) is not None:
        return False  # the product itself would pass through
    operands = _operands(rewrite, node, product, port)
    if operands is None:
        return False
    change_operation(rewrite, node, Opcode.FMA, operands)
    rewrite.remove_node(product.id)
    return True


def _operands(rewrite: Rewrite, node: Node, product: Node, port: int) -> list[Value] | None:
    """Operands of the `fma`; None if a negation would cost an operation."""
    first, second = rewrite.operands(product)
    addend = rewrite.operand(node.id, 1 - port)
    if node.op is Opcode.FADD:
        return [first, second, addend]
    if port == 1:
        return _with_negated_factor(rewrite, first, second, addend)
    if rewrite.predicated(node.id):
        return None  # the subtraction passes c through, the fma would pass -c
    negated = _negated(rewrite, addend)
    return None if negated is None else [first, second, negated]


def _product(rewrite: Rewrite, value: Value) -> Node | None:
    source = rewrite.nodes[value.src]
    if source.op is not Opcode.FMUL or value.distance or source.control is not None:
        return None
    if rewrite.predicated(source.id) or len(rewrite.uses(source.id)) != 1:
        return None
    return source


def _with_negated_factor(
    rewrite: Rewrite, first: Value, second: Value, addend: Value
) -> list[Value] | None:
    for factor, other in ((second, first), (first, second)):
        negated = _negated(rewrite, factor)
        if negated is not None:
            return [other, negated, addend]
    return None


def _negated(rewrite: Rewrite, value: Value) -> Value | None:
    """A value that is `-value` at no cost."""
    word = rewrite.word(value)
    if word is not None:
        return Value(rewrite.constant(word ^ SIGN_BIT))
    source = rewrite.nodes[value.src]
    if source.op is not Opcode.FNEG or value.distance or rewrite.predicated(source.id):
        return None
    return rewrite.operand(source.id, 0)
