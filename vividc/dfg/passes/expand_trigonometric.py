"""sin, cos and tan in operations of the array.

An argument that is seen to stay below 2**17 in magnitude (a minimum and a maximum with constants, a
remainder, a sine, a product of such: `argument_magnitudes`) needs 48 operations less.
"""

from __future__ import annotations

from typing import Final

from vividc.dfg.passes.expand_angle import reduced_angle
from vividc.dfg.passes.expand_builder import ONE, Builder
from vividc.dfg.passes.expand_divide import quotient
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode

LARGEST_SMALL_ANGLE: Final = 2.0**17
# With u = r**2 on |r| <= pi/4, from the highest power to the constant: (sin(r) / r - 1) / u and
# (cos(r) - 1) / u, whose constant is set to -1/2. Absolute errors 2**-27.8 and 2**-33.1 (least
# squares at 400 Chebyshev points with weight u, the coefficients rounded one after the other from
# the constant on).
SINE: Final = (0xB94C95FA, 0x3C088372, 0xBE2AAAA2)
COSINE: Final = (0x37CCF561, 0xBAB60617, 0x3D2AAAA5, 0xBF000000)


def sine(b: Builder, x: Value) -> Value:
    """sin(x), as sin(|x|) with the sign of x."""
    sin, cos, q, odd = _parts(b, x)
    value = b.op(Opcode.SELECT, odd, cos, sin)
    return b.times_sign(value, b.op(Opcode.XOR, b.op(Opcode.SHL, q, 30), x))


def cosine(b: Builder, x: Value) -> Value:
    """cos(x)."""
    sin, cos, q, odd = _parts(b, x)
    value = b.op(Opcode.SELECT, odd, sin, cos)
    return b.times_sign(value, b.op(Opcode.SHL, b.op(Opcode.ADD, q, 1), 30))


def tangent(b: Builder, x: Value) -> Value:
    """tan(x): sin(r) / cos(r), or -cos(r) / sin(r) in odd quadrants. |sin(r)| is 2**-30 at least
    there.
    """
    sin, cos, q, odd = _parts(b, x)
    value = quotient(b, b.op(Opcode.SELECT, odd, cos, sin), b.op(Opcode.SELECT, odd, sin, cos))
    return b.times_sign(value, b.op(Opcode.XOR, b.op(Opcode.SHL, q, 31), x))


def _parts(b: Builder, x: Value) -> tuple[Value, Value, Value, Value]:
    """sin(r), cos(r), q and whether q is odd."""
    small = b.magnitude < LARGEST_SMALL_ANGLE
    r, q = reduced_angle(b, b.op(Opcode.FABS, x), small=small)
    u = b.op(Opcode.FMUL, r, r)
    sin = b.op(Opcode.FMA, b.op(Opcode.FMUL, u, r), b.horner(SINE, u), r)
    cos = b.op(Opcode.FMA, b.horner(COSINE, u), u, ONE)
    return sin, cos, q, b.op(Opcode.AND, q, 1)
