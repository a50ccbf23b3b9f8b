"""Expansion of elementary functions into the operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.ir import DFG, Node
from vividc.dfg.opcodes import PRED, Opcode
from vividc.dfg.passes.rewrite import Rewrite, Value, to_fixpoint

# All words are binary32 bits.
LOG2_E: Final = 0x3FB8AA3B
# 1.5 * 2**23 + 126: added to a float below 2**22 it leaves the rounded integer, 126 higher, in the
# low bits.
ROUNDING_MAGIC: Final = 0x4B40007E
# The magic number + 129: past the largest exponent, so that its scale is infinity.
ROUNDED_LIMIT: Final = 0x4B4000FF
# -ln 2 in two words (Cody and Waite, Software Manual for the Elementary Functions, 1980).
MINUS_LN2_HIGH: Final = 0xBF317218
MINUS_LN2_LOW: Final = 0x3102E308
# 2 exp(r) on |r| <= ln(2) / 2, relative error 2**-28.2, from the highest power to the constant.
POLYNOMIAL: Final = (
    0x3B35265A,
    0x3C891CC3,
    0x3DAAAC58,
    0x3EAAAA49,
    0x3F7FFFFE,
    0x40000000,
    0x40000000,
)
EXPONENT_SHIFT: Final = 23
SMALLEST_ARGUMENT: Final = 0xC2AE0000  # -87.0


def expand_math(dfg: DFG) -> DFG:
    """Replace each `exp` by 14 operations, none of them a division or a table.

    With n = round(x / ln 2) and r = x - n ln 2, exp(x) = 2**(n-1) * 2 exp(r). The rounding is the
    addition of a large number, whose low bits are then the biased exponent of the scale; 2 exp(r)
    is a polynomial of degree 6 in Horner form (minimax, the coefficients rounded one after the
    other).

    Over all 2**32 inputs the error is at most 0.892 ulp wherever the result is 2**-125.5 (1.66e-38)
    or more. Smaller results (x < -86.99) are 0; overflow (x > 88.72) gives infinity; NaN gives the
    canonical NaN; exp(+-0) is 1.
    """
    return to_fixpoint(dfg, _expand)


def _expand(rewrite: Rewrite, node: Node) -> bool:
    if node.op is not Opcode.EXP:
        return False
    x = rewrite.operand(node.id, 0)

    def op(opcode: Opcode, *operands: Value) -> Value:
        return Value(rewrite.add_node(opcode, operands, node.loc))

    def word(bits: int) -> Value:
        return Value(rewrite.constant(bits))

    magic = word(ROUNDING_MAGIC)
    # A NaN loses against the limit here, but makes r and so the polynomial NaN.
    shifted = op(Opcode.FMIN, op(Opcode.FMA, x, word(LOG2_E), magic), word(ROUNDED_LIMIT))
    n = op(Opcode.FSUB, shifted, magic)
    r = op(Opcode.FMA, n, word(MINUS_LN2_HIGH), x)
    r = op(Opcode.FMA, n, word(MINUS_LN2_LOW), r)
    value = word(POLYNOMIAL[0])
    for coefficient in POLYNOMIAL[1:]:
        value = op(Opcode.FMA, value, r, word(coefficient))
    scale = op(Opcode.SHL, shifted, word(EXPONENT_SHIFT))
    # Far below the range r and n are meaningless: the predicated FMA passes its 0 through.
    in_range = op(Opcode.FCMP_ULE, word(SMALLEST_ARGUMENT), x)
    result = rewrite.add_node(Opcode.FMA, (value, scale, word(0)), node.loc)
    rewrite.set_operand(result, PRED, in_range)
    _replace(rewrite, node, result)
    return True


def _replace(rewrite: Rewrite, node: Node, result: int) -> None:
    """Let the readers of an `exp` read `result`; a predicated `exp` passes its operand through."""
    pred = rewrite.edge(node.id, PRED)
    value = Value(result)
    if pred is not None:
        passed = rewrite.operand(node.id, 0)
        guard = Value(pred.src, pred.distance, pred.init)
        value = Value(rewrite.add_node(Opcode.SELECT, (guard, value, passed), node.loc))
    rewrite.forward(node.id, value)
    rewrite.remove_node(node.id)
