"""What the elementary operations compute: those that `expand_math` replaces, since no FU has them.

Quotients and roots survive the rounding to binary64 and then to binary32; the transcendental
functions are correctly rounded wherever binary64's are not within a rounding error of a tie.
Integer division truncates towards zero; by zero the quotient is 0 and the remainder the dividend,
and INT_MIN / -1 wraps. The counts of leading and trailing zeros of 0 are 32.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from vividc.machine.elementary_float import FLOAT_SEMANTICS
from vividc.machine.opcodes import Opcode
from vividc.machine.words import (
    CANONICAL_NAN,
    INFINITY,
    SIGN_BIT,
    WORD_BITS,
    WORD_MASK,
    float_of,
    signed,
    word_of,
)

_EXP_OVERFLOWS: Final = 100.0  # binary32 does from 88.73 on; math.exp would raise above 709.78
_EXP2_OVERFLOWS: Final = 200.0  # binary32 does from 128 on; math.exp2 would raise at 1024


def _exp(a: int) -> int:
    x = float_of(a)
    if x > _EXP_OVERFLOWS:
        return INFINITY
    return word_of(math.exp(x))


def _exp2(a: int) -> int:
    x = float_of(a)
    if x > _EXP2_OVERFLOWS:
        return INFINITY
    return word_of(math.exp2(x))


def _fdiv(a: int, b: int) -> int:
    x, y = float_of(a), float_of(b)
    if y != 0.0:
        return word_of(x / y)
    if x == 0.0 or math.isnan(x):
        return CANONICAL_NAN
    return INFINITY | ((a ^ b) & SIGN_BIT)


def _sqrt(a: int) -> int:
    x = float_of(a)
    return CANONICAL_NAN if x < 0.0 else word_of(math.sqrt(x))


def _floor(a: int) -> int:
    return _integral(a, math.floor)


def _ceil(a: int) -> int:
    return _integral(a, math.ceil)


def _integral(a: int, rounding: Callable[[float], int]) -> int:
    x = float_of(a)
    if not math.isfinite(x):
        return word_of(x)
    return word_of(math.copysign(rounding(x), x))


def _sdiv(a: int, b: int) -> int:
    x, y = signed(a), signed(b)
    if y == 0:
        return 0
    quotient = abs(x) // abs(y)
    return (quotient if (x < 0) == (y < 0) else -quotient) & WORD_MASK


def _srem(a: int, b: int) -> int:
    x, y = signed(a), signed(b)
    if y == 0:
        return a
    remainder = abs(x) % abs(y)
    return (remainder if x >= 0 else -remainder) & WORD_MASK


def _udiv(a: int, b: int) -> int:
    return a // b if b else 0


def _urem(a: int, b: int) -> int:
    return a % b if b else a


def _ctpop(a: int) -> int:
    return a.bit_count()


def _ctlz(a: int) -> int:
    return WORD_BITS - a.bit_length()


def _cttz(a: int) -> int:
    return (a & -a).bit_length() - 1 if a else WORD_BITS


def _bswap(a: int) -> int:
    return int.from_bytes(a.to_bytes(4, "little"), "big")


def _bitreverse(a: int) -> int:
    return int(f"{a:032b}"[::-1], 2)


ELEMENTARY_SEMANTICS: Final[dict[Opcode, Callable[..., int]]] = {
    Opcode.EXP: _exp,
    Opcode.EXP2: _exp2,
    Opcode.FDIV: _fdiv,
    Opcode.SQRT: _sqrt,
    Opcode.FLOOR: _floor,
    Opcode.CEIL: _ceil,
    Opcode.SDIV: _sdiv,
    Opcode.UDIV: _udiv,
    Opcode.SREM: _srem,
    Opcode.UREM: _urem,
    Opcode.CTPOP: _ctpop,
    Opcode.CTLZ: _ctlz,
    Opcode.CTTZ: _cttz,
    Opcode.BSWAP: _bswap,
    Opcode.BITREVERSE: _bitreverse,
    **FLOAT_SEMANTICS,
}
