"""What the elementary functions of floats compute: binary64's values, rounded to binary32.

Exceptional arguments are as in C99, annex F: `pow(x, 0)` and `pow(1, y)` are 1 even for a NaN,
`hypot` of an infinity is infinite even beside a NaN, `frem` is C's `fmod`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import CANONICAL_NAN, INFINITY, SIGN_BIT, float_of, word_of

_MINUS_INFINITY: Final = INFINITY | SIGN_BIT


def _plain(function: Callable[[float], float]) -> Callable[[int], int]:
    """Where Python raises, the function is not defined (ValueError) or too large (OverflowError);
    none of these overflows for negative arguments only.
    """

    def words(a: int) -> int:
        try:
            return word_of(function(float_of(a)))
        except ValueError:
            return CANONICAL_NAN
        except OverflowError:
            return INFINITY

    return words


def _logarithm(function: Callable[[float], float], pole: float) -> Callable[[int], int]:
    inside = _plain(function)
    return lambda a: _MINUS_INFINITY if float_of(a) == pole else inside(a)


def _sinh(a: int) -> int:
    x = float_of(a)
    try:
        return word_of(math.sinh(x))
    except OverflowError:
        return word_of(math.copysign(math.inf, x))


def _rint(a: int) -> int:
    x = float_of(a)
    return word_of(math.copysign(round(x), x) if math.isfinite(x) else x)


def _trunc(a: int) -> int:
    x = float_of(a)
    return word_of(math.copysign(math.trunc(x), x) if math.isfinite(x) else x)


def _atan2(a: int, b: int) -> int:
    return word_of(math.atan2(float_of(a), float_of(b)))


def _hypot(a: int, b: int) -> int:
    return word_of(math.hypot(float_of(a), float_of(b)))


def _pow(a: int, b: int) -> int:
    x, y = float_of(a), float_of(b)
    odd = math.isfinite(y) and abs(math.fmod(y, 2.0)) == 1.0
    try:
        return word_of(math.pow(x, y))
    except ValueError:
        if x != 0.0:
            return CANONICAL_NAN
    except OverflowError:
        pass
    return _MINUS_INFINITY if odd and math.copysign(1.0, x) < 0.0 else INFINITY


def _frem(a: int, b: int) -> int:
    x, y = float_of(a), float_of(b)
    if math.isinf(x) or y == 0.0:
        return CANONICAL_NAN
    return word_of(math.fmod(x, y))


FLOAT_SEMANTICS: Final[dict[Opcode, Callable[..., int]]] = {
    Opcode.TRUNC: _trunc,
    Opcode.RINT: _rint,
    Opcode.LOG: _logarithm(math.log, 0.0),
    Opcode.LOG2: _logarithm(math.log2, 0.0),
    Opcode.LOG10: _logarithm(math.log10, 0.0),
    Opcode.LOG1P: _logarithm(math.log1p, -1.0),
    Opcode.EXPM1: _plain(math.expm1),
    Opcode.SIN: _plain(math.sin),
    Opcode.COS: _plain(math.cos),
    Opcode.TAN: _plain(math.tan),
    Opcode.SINH: _sinh,
    Opcode.COSH: _plain(math.cosh),
    Opcode.TANH: _plain(math.tanh),
    Opcode.ASIN: _plain(math.asin),
    Opcode.ACOS: _plain(math.acos),
    Opcode.ATAN: _plain(math.atan),
    Opcode.ATAN2: _atan2,
    Opcode.HYPOT: _hypot,
    Opcode.POW: _pow,
    Opcode.FREM: _frem,
}
