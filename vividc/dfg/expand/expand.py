"""Expansion of elementary functions into the operations of the array."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from vividc.dfg.expand.arc import arccosine, arcsine, arctangent, arctangent2
from vividc.dfg.expand.bits import (
    count_ones,
    leading_zeros,
    reverse_bits,
    swap_bytes,
    trailing_zeros,
)
from vividc.dfg.expand.builder import Builder, Expansion
from vividc.dfg.expand.divide import divide
from vividc.dfg.expand.exp import exponential, power_of_two
from vividc.dfg.expand.exp_narrow import expansion
from vividc.dfg.expand.hyperbolic import (
    exponential_minus_one,
    hyperbolic_cosine,
    hyperbolic_sine,
    hyperbolic_tangent,
)
from vividc.dfg.expand.integer import (
    signed_quotient,
    signed_remainder,
    unsigned_quotient,
    unsigned_remainder,
)
from vividc.dfg.expand.log import (
    binary_logarithm,
    decimal_logarithm,
    logarithm_of_successor,
    natural_logarithm,
)
from vividc.dfg.expand.magnitudes import argument_magnitudes
from vividc.dfg.expand.power import power
from vividc.dfg.expand.remainder import remainder
from vividc.dfg.expand.roots import hypotenuse, square_root
from vividc.dfg.expand.round import ceil, floor, round_half_even, truncate
from vividc.dfg.expand.trigonometric import cosine, sine, tangent
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
    chosen = {opcode: expansion(opcode, fmt) for opcode, fmt in formats_of(policy).items()}

    def expand_math_in_formats(dfg: DFG) -> DFG:
        return _expanded(dfg, EXPANSIONS | chosen)

    return expand_math_in_formats


def _expanded(dfg: DFG, expansions: Mapping[Opcode, Expansion]) -> DFG:
    # Before: an expanded remainder or sine no longer shows its range.
    known = argument_magnitudes(dfg)
    return to_fixpoint(dfg, lambda rewrite, node: _expand(rewrite, node, known, expansions))


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.EXP: exponential,
    Opcode.EXP2: power_of_two,
    Opcode.FDIV: divide,
    Opcode.SQRT: square_root,
    Opcode.FLOOR: floor,
    Opcode.CEIL: ceil,
    Opcode.UDIV: unsigned_quotient,
    Opcode.UREM: unsigned_remainder,
    Opcode.SDIV: signed_quotient,
    Opcode.SREM: signed_remainder,
    Opcode.CTPOP: count_ones,
    Opcode.CTLZ: leading_zeros,
    Opcode.CTTZ: trailing_zeros,
    Opcode.BSWAP: swap_bytes,
    Opcode.BITREVERSE: reverse_bits,
    Opcode.SIN: sine,
    Opcode.COS: cosine,
    Opcode.TAN: tangent,
    Opcode.TRUNC: truncate,
    Opcode.RINT: round_half_even,
    Opcode.ASIN: arcsine,
    Opcode.ACOS: arccosine,
    Opcode.ATAN: arctangent,
    Opcode.ATAN2: arctangent2,
    Opcode.HYPOT: hypotenuse,
    Opcode.POW: power,
    Opcode.FREM: remainder,
    Opcode.EXPM1: exponential_minus_one,
    Opcode.SINH: hyperbolic_sine,
    Opcode.COSH: hyperbolic_cosine,
    Opcode.TANH: hyperbolic_tangent,
    Opcode.LOG: natural_logarithm,
    Opcode.LOG2: binary_logarithm,
    Opcode.LOG10: decimal_logarithm,
    Opcode.LOG1P: logarithm_of_successor,
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
