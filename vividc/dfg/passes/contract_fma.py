"""Contraction of a multiplication and an addition into one fused operation."""

from __future__ import annotations

from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation, to_fixpoint
from vividc.machine.opcodes import FUSED, PRED, Opcode


def contract_fma(dfg: DFG) -> DFG:
    """Turn `a*b + c`, `a*b - c` and `c - a*b` into one operation, which rounds once instead of
    twice.

    The product must have no other reader. A predicated sum is contracted only if it passes `c`
    through, as the fused one will.
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
    operands = [*rewrite.operands(product), rewrite.operand(node.id, 1 - port)]
    change_operation(rewrite, node, FUSED[node.op, port], operands)
    rewrite.remove_node(product.id)
    return True


def _product(rewrite: Rewrite, value: Value) -> Node | None:
    source = rewrite.nodes[value.src]
    if source.op is not Opcode.FMUL or value.distance or source.control is not None:
        return None
    if rewrite.predicated(source.id) or len(rewrite.uses(source.id)) != 1:
        return None
    return source
