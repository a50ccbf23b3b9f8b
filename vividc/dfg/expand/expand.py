"""Expansion of elementary functions into the operations of the array."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from vividc.dfg.expand import (
    arc,
    bits,
    divide,
    exp,
    hyperbolic,
    integer,
    log,
    power,
    remainder,
    roots,
    rounding,
    trigonometric,
)
from vividc.dfg.expand.builder import Builder, Expansion
from vividc.dfg.expand.exp import exponential_in
from vividc.dfg.expand.magnitudes import argument_magnitudes
from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, to_fixpoint
from vividc.machine.opcodes import PRED, Opcode
from vividc.ssa.formats.precision import Precision, formats_of


def expand_math(dfg: DFG) -> DFG:
    """Replace each elementary function by operations of the array, none of them a table.

    The expansions (`exponential`, `divide`, `square_root`, ...) state their accuracy. The result
    has no operation of `ELEMENTARY`.
    """
    return _expanded(dfg, EXPANSIONS)


def expansion_pass(policy: Precision) -> Callable[[DFG], DFG]:
    """`expand_math` under a precision policy."""
    if not policy:
        return expand_math
    chosen = {opcode: exponential_in(opcode, fmt) for opcode, fmt in formats_of(policy).items()}

    def expand_math_in_formats(dfg: DFG) -> DFG:
        return _expanded(dfg, EXPANSIONS | chosen)

    return expand_math_in_formats


def _expanded(dfg: DFG, expansions: Mapping[Opcode, Expansion]) -> DFG:
    if not any(node.op in expansions for node in dfg.nodes):
        return dfg
    # Before: an expanded remainder or sine no longer shows its range.
    known = argument_magnitudes(dfg)
    return to_fixpoint(dfg, lambda rewrite, node: _expand(rewrite, node, known, expansions))


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    opcode: expand
    for module in (
        exp,
        divide,
        roots,
        rounding,
        integer,
        bits,
        trigonometric,
        arc,
        power,
        remainder,
        hyperbolic,
        log,
    )
    for opcode, expand in module.EXPANSIONS.items()
}


def _expand(
    rewrite: Rewrite,
    node: Node,
    known: Mapping[int, float],
    expansions: Mapping[Opcode, Expansion],
) -> bool:
    expand = expansions.get(node.op)
    if expand is None:
        return False
    operands = rewrite.operands(node)
    value = expand(Builder(rewrite, node, known.get(node.id, math.inf)), *operands)
    pred = rewrite.edge(node.id, PRED)
    if pred is not None:
        guard = Value(pred.src, pred.distance, pred.init)
        value = Builder(rewrite, node).op(Opcode.SELECT, guard, value, operands[-1])
    if node.control is not None:  # a quotient may be a trip count
        rewrite.set_node(replace(rewrite.nodes[value.src], control=node.control))
    rewrite.forward(node.id, value)
    rewrite.remove_node(node.id)
    return True
