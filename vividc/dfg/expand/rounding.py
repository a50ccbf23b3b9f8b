"""Rounding to integers in operations of the array: exact."""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import ONE, SIGN, Builder, Expansion
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

MINUS_ONE: Final = ONE | SIGN
ALL_INTEGERS: Final = 0x4B000000  # 2**23: from here on every binary32 is an integer


def floor(b: Builder, x: Value) -> Value:
    """The largest integer not above x, in 10 operations; -0 and infinities stay."""
    near = _truncated(b, x)
    return _finish(b, x, b.op(Opcode.FADD, MINUS_ONE, near, pred=b.op(Opcode.FCMP_OLT, x, near)))


def ceil(b: Builder, x: Value) -> Value:
    """The smallest integer not below x, in 10 operations; results in (-1, 0] are -0."""
    near = _truncated(b, x)
    return _finish(b, x, b.op(Opcode.FADD, ONE, near, pred=b.op(Opcode.FCMP_OLT, near, x)))


def truncate(b: Builder, x: Value) -> Value:
    """The integer next to x towards zero, in 9 operations."""
    return _finish(b, x, _truncated(b, x))


def round_half_even(b: Builder, x: Value) -> Value:
    """The integer nearest to x, of two the even one, in 9 operations: added to 2**23 a smaller
    number loses its fraction.
    """
    shifted = b.op(Opcode.FADD, b.op(Opcode.FABS, x), ALL_INTEGERS)
    return _finish(b, x, b.op(Opcode.FSUB, shifted, ALL_INTEGERS))


def _truncated(b: Builder, x: Value) -> Value:
    return b.op(Opcode.SITOFP, b.op(Opcode.FPTOSI, x))


def _finish(b: Builder, x: Value, integer: Value) -> Value:
    """`integer` with the sign of x, or x itself where the conversion may have saturated."""
    fraction = b.op(Opcode.FCMP_OLT, b.op(Opcode.FABS, x), ALL_INTEGERS)
    with_sign = b.op(Opcode.OR, integer, b.op(Opcode.AND, x, SIGN))
    # The product is x, and a NaN made canonical.
    return b.op(Opcode.SELECT, fraction, with_sign, b.op(Opcode.FMUL, x, ONE))


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.FLOOR: floor,
    Opcode.CEIL: ceil,
    Opcode.TRUNC: truncate,
    Opcode.RINT: round_half_even,
}
