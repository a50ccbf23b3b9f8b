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
# (1 - 2 r)**-0.5 - 1 - r over r**2, from the constant on: to 1e-9 of the root. The constant is
# 7.6e-6 below the best, so that no root just below a power of two comes out as one.
SERIES: Final = (0x3FBFFF7A, 0x4020000A, 0x408CBFDD, 0x40FCADF6)
# Below 2**-96 the residual x - g**2 would underflow: such x is scaled by 2**64, its root by 2**-32.
SMALL: Final = 0x0F800000
UP: Final = 0x5F800000
DOWN: Final = 0x2F800000
DOWN_BITS: Final = -(32 << EXPONENT_SHIFT) & 0xFFFFFFFF  # the same of an exponent
ULP: Final = -(150 << EXPONENT_SHIFT) & 0xFFFFFFFF  # of 1, and twice the exponent's bias


def square_root(b: Builder, x: Value) -> Value:
    """The square root of x: in 29 operations that take 35 cycles where latency binds, else in 23
    that take 48. Both give the same words.

    Correctly rounded for every x, subnormals included; sqrt(+-0) is +-0; a negative x gives NaN.
    """
    small = b.op(Opcode.FCMP_OLT, x, SMALL)
    near = b.op(Opcode.FMUL, UP, x, pred=small)
    if b.latency_binds:
        root, above, below = _candidates(b, near)
        root = b.stepped(b.op(Opcode.ADD, DOWN_BITS, root, pred=small), above, below)
    else:
        root = b.op(Opcode.FMUL, DOWN, _corrected_root(b, near), pred=small)
    negative = b.op(Opcode.FCMP_ULT, x, 0)
    special = b.op(Opcode.FADD, NAN, x, pred=negative)  # a zero, infinity or NaN
    return b.op(Opcode.SELECT, b.is_finite_nonzero(x), root, special)


def root_of_normal(b: Builder, x: Value) -> Value:
    """sqrt(x) for 0 and 2**-96 <= x < infinity, correctly rounded; of other x only a NaN gives what
    it should. In 21 operations where latency binds, else in 13.
    """
    return b.stepped(*_candidates(b, x)) if b.latency_binds else _corrected_root(b, x)


def _corrected_root(b: Builder, x: Value) -> Value:
    """sqrt(x) by Goldschmidt's coupled iteration on g, about sqrt(x), and h, about 1/(2 sqrt(x)),
    and a correction by the exact residual x - g**2 (Markstein, "Computation of elementary functions
    on the IBM RISC System/6000 processor", 1990).

    All mantissas of two binades were tried, and the steps are the same in every other pair.
    """
    y = b.op(Opcode.SUB, INVERSE_ROOT_MAGIC, b.op(Opcode.LSHR, x, 1))
    g = b.op(Opcode.FMUL, x, y)
    minus_h = b.op(Opcode.FMUL, y, MINUS_HALF)
    for _ in range(3):  # 3.44e-2, 1.8e-3, 4.7e-6, then the roundings of g and minus_h remain
        r = b.op(Opcode.FMA, g, minus_h, HALF)
        g = b.op(Opcode.FMA, g, r, g)
        minus_h = b.op(Opcode.FMA, minus_h, r, minus_h)
    return b.op(Opcode.FMA, b.op(Opcode.FMS, g, g, x), minus_h, g)


def _candidates(b: Builder, x: Value) -> tuple[Value, Value, Value]:
    """A number at most one and a half units in the last place from sqrt(x), and whether the next
    number above, or below, is nearer.

    With y about 1/sqrt(x) of an integer subtraction, g = x y and r = 1/2 - g y / 2, the root is
    g (1 - 2 r)**-0.5, of which a polynomial is taken whose terms are computed side by side. The
    root is nearer to the number above where the exact residual x - g**2 is more than g units in
    the last place, as all of these are multiples of the unit's square. All mantissas of two
    binades were tried, and the steps are the same in every other pair.
    """
    y = b.op(Opcode.SUB, INVERSE_ROOT_MAGIC, b.op(Opcode.LSHR, x, 1))
    g = b.op(Opcode.FMUL, x, y)
    r = b.op(Opcode.FMA, g, b.op(Opcode.FMUL, y, MINUS_HALF), HALF)
    square = b.op(Opcode.FMUL, r, r)
    first = b.op(Opcode.FMA, g, r, g)
    low = b.op(Opcode.FMA, SERIES[1], r, SERIES[0])
    high = b.op(Opcode.FMA, SERIES[3], r, SERIES[2])
    rest = b.op(Opcode.FMA, high, square, low)
    g = b.op(Opcode.FMA, b.op(Opcode.FMUL, g, square), rest, first)
    residual = b.op(Opcode.FNMA, g, g, x)
    unit = b.op(Opcode.ADD, b.op(Opcode.AND, g, EXPONENT), ULP)
    reach = b.op(Opcode.ADD, g, unit)
    above = b.op(Opcode.FCMP_OLT, reach, residual)
    below = b.op(Opcode.FCMP_OLE, residual, b.op(Opcode.FNEG, reach))
    return g, above, below


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
