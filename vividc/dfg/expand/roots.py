"""Square roots and hypotenuses in operations of the array; roots are correctly rounded."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT, EXPONENT_SHIFT, Builder, Expansion
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

# Halves and negates the exponent (Lomont, "Fast inverse square root", 2003): 3.44 % off at most.
INVERSE_ROOT_MAGIC: Final = 0x5F375A86
HALF: Final = 0x3F000000
MINUS_HALF: Final = 0xBF000000
NAN: Final = 0x7FC00000
# Below 2**-96 the residual x - g**2 would underflow: such x is scaled by 2**64, its root by 2**-32.
SMALL: Final = 0x0F800000
UP: Final = 0x5F800000
DOWN: Final = 0x2F800000


def square_root(b: Builder, x: Value) -> Value:
    """The square root of x in 25 operations.

    An estimate of 1/sqrt(x) by an integer subtraction, then Goldschmidt's coupled iteration on g,
    about sqrt(x), and h, about 1/(2 sqrt(x)), and a correction by the exact residual x - g**2
    (Markstein, "Computation of elementary functions on the IBM RISC System/6000 processor", 1990).

    Correctly rounded for every x, subnormals included: all mantissas of two binades were tried, and
    the steps are the same in every other pair. sqrt(+-0) is +-0; a negative x gives NaN.
    """
    small = b.op(Opcode.FCMP_OLT, x, SMALL)
    near = b.op(Opcode.FMUL, UP, x, pred=small)
    root = root_of_normal(b, near)
    root = b.op(Opcode.FMUL, DOWN, root, pred=small)
    negative = b.op(Opcode.FCMP_OLT, x, 0)
    # x + x is x where x is a zero, infinite or NaN.
    special = b.op(Opcode.SELECT, negative, NAN, b.op(Opcode.FADD, x, x))
    return b.op(Opcode.SELECT, b.is_finite_nonzero(x), root, special)


def root_of_normal(b: Builder, x: Value) -> Value:
    """sqrt(x) in 14 operations for 0 and 2**-96 <= x < infinity, correctly rounded; of other x only
    a NaN gives what it should. The signs are such that no negation is between the steps.
    """
    y = b.op(Opcode.SUB, INVERSE_ROOT_MAGIC, b.op(Opcode.LSHR, x, 1))
    g = b.op(Opcode.FMUL, x, y)
    minus_h = b.op(Opcode.FMUL, y, MINUS_HALF)
    minus_x = b.op(Opcode.FNEG, x)
    for _ in range(3):  # 3.44e-2, 1.8e-3, 4.7e-6, then the roundings of g and minus_h remain
        r = b.op(Opcode.FMA, g, minus_h, HALF)
        g = b.op(Opcode.FMA, g, r, g)
        minus_h = b.op(Opcode.FMA, minus_h, r, minus_h)
    return b.op(Opcode.FMA, b.op(Opcode.FMA, g, g, minus_x), minus_h, g)


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


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.SQRT: square_root,
    Opcode.HYPOT: hypotenuse,
}
