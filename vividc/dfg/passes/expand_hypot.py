"""The hypotenuse in operations of the array."""

from __future__ import annotations

from typing import Final

from vividc.dfg.passes.expand_builder import EXPONENT, EXPONENT_SHIFT, Builder
from vividc.dfg.passes.expand_sqrt import root_of_normal
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

NAN: Final = 0x7FC00000
SMALLEST_EXPONENT: Final = 1 << EXPONENT_SHIFT
# A scale and its inverse, both normal, add up to 254 in the exponent field.
LARGEST_EXPONENT: Final = 253 << EXPONENT_SHIFT
SCALES: Final = 254 << EXPONENT_SHIFT


def hypotenuse(b: Builder, x: Value, y: Value) -> Value:
    """sqrt(x**2 + y**2) without spurious overflow: the larger magnitude is scaled to [1, 4), or to
    what is left of it if it is subnormal.

    An infinity gives infinity, even beside a NaN (C99).
    """
    a, c = b.op(Opcode.FABS, x), b.op(Opcode.FABS, y)
    large, small = b.op(Opcode.FMAX, a, c), b.op(Opcode.FMIN, a, c)
    scale = b.op(Opcode.SMAX, b.op(Opcode.AND, large, EXPONENT), SMALLEST_EXPONENT)
    scale = b.op(Opcode.SMIN, scale, LARGEST_EXPONENT)
    inverse = b.op(Opcode.SUB, SCALES, scale)
    p, q = b.op(Opcode.FMUL, large, inverse), b.op(Opcode.FMUL, small, inverse)
    square = b.op(Opcode.FMA, p, p, b.op(Opcode.FMUL, q, q))
    value = b.op(Opcode.FMUL, root_of_normal(b, square), scale)
    value = b.op(Opcode.SELECT, b.op(Opcode.FCMP_ORD, x, y), value, NAN)
    return b.op(Opcode.SELECT, b.op(Opcode.FCMP_OEQ, large, EXPONENT), large, value)
