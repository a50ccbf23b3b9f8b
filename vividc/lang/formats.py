"""Numbers of less than 32 bits in plain Python: `vividc.lang.fp16`, `fp8` and `e5m2`.

A `Narrow` is what a kernel computes with when neither numba nor the array runs it; both do the same
(`numba_types`). Arithmetic is of two numbers of one format and rounds once; anything else needs a
cast.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import numpy as np

from vividc.formats import E4M3, E5M2, F16, Format, round_bits, to_float

NAMES: Final = {F16: "float16", E4M3: "float8 E4M3", E5M2: "float8 E5M2"}
"""What a message calls a format."""
MISUSE: Final = "vividc: "
"""Starts what numba is told that a user did wrong with a format: reason, ": ", hint."""
CASTS: Final = {F16: "fp16", E4M3: "fp8", E5M2: "e5m2"}
"""Name in `vividc.lang` of the cast to a format."""


@dataclass(frozen=True, slots=True, eq=False)
class Narrow:
    """A number of a format.

    Attributes
    ----------
    format
        float16, float8 E4M3 or float8 E5M2.
    bits
        Its code.
    """

    format: Format
    bits: int

    def __float__(self) -> float:
        return to_float(self.format, self.bits)

    def __repr__(self) -> str:
        return f"{CASTS[self.format]}({float(self)})"

    def __bool__(self) -> bool:
        return float(self) != 0.0

    def __hash__(self) -> int:
        return hash(float(self))

    def __add__(self, other: Narrow) -> Narrow:
        return self._rounded(float(self) + self._same(other))

    def __sub__(self, other: Narrow) -> Narrow:
        return self._rounded(float(self) - self._same(other))

    def __mul__(self, other: Narrow) -> Narrow:
        return self._rounded(float(self) * self._same(other))

    def __neg__(self) -> Narrow:
        return Narrow(self.format, self.bits ^ self.format.sign)

    def __abs__(self) -> Narrow:
        return Narrow(self.format, self.bits & ~self.format.sign)

    def __pos__(self) -> Narrow:
        return self

    def __eq__(self, other: object) -> bool:
        return float(self) == self._same(other)

    def __ne__(self, other: object) -> bool:
        return float(self) != self._same(other)

    def __lt__(self, other: Narrow) -> bool:
        return float(self) < self._same(other)

    def __le__(self, other: Narrow) -> bool:
        return float(self) <= self._same(other)

    def __gt__(self, other: Narrow) -> bool:
        return float(self) > self._same(other)

    def __ge__(self, other: Narrow) -> bool:
        return float(self) >= self._same(other)

    def _same(self, other: object) -> float:
        if isinstance(other, Narrow) and other.format is self.format:
            return float(other)
        kind = NAMES[other.format] if isinstance(other, Narrow) else type(other).__name__
        raise TypeError(mixed(NAMES[self.format], kind, CASTS[self.format]))

    def _rounded(self, exact: float) -> Narrow:
        """A sum or product of two numbers of a format is exact in binary64."""
        return Narrow(self.format, round_bits(self.format, exact))


def mixed(left: str, right: str, cast: str) -> str:
    """What is wrong with arithmetic between two types."""
    return f"`{left}` and `{right}` in one operation: cast one, as in lang.{cast}(...)"


def _cast(fmt: Format, value: Any) -> Narrow:
    if isinstance(value, Narrow) and value.format is fmt:
        return value
    with np.errstate(over="ignore"):
        return Narrow(fmt, round_bits(fmt, float(np.float32(float(value)))))


def fp16(value: Any) -> Narrow:
    """A number as float16 (IEEE 754 binary16).

    Parameters
    ----------
    value
        A number, taken as float32 unless it is narrower: what rounds to more than 65504 is
        infinity.
    """
    return _cast(F16, value)


def fp8(value: Any) -> Narrow:
    """A number as float8 E4M3 (OCP 8-bit Floating Point Specification, 2023).

    Parameters
    ----------
    value
        A number, taken as float32 unless it is narrower: what is beyond 448 saturates.
    """
    return _cast(E4M3, value)


def e5m2(value: Any) -> Narrow:
    """A number as float8 E5M2 (OCP 8-bit Floating Point Specification, 2023).

    Parameters
    ----------
    value
        A number, taken as float32 unless it is narrower: what rounds to more than 57344 is
        infinity.
    """
    return _cast(E5M2, value)


def fp16_from_bits(bits: int) -> Narrow:
    """The float16 whose code is in the low 16 bits."""
    return Narrow(F16, int(bits) & F16.mask)


def fp8_from_bits(bits: int) -> Narrow:
    """The float8 E4M3 whose code is in the low 8 bits."""
    return Narrow(E4M3, int(bits) & E4M3.mask)


def e5m2_from_bits(bits: int) -> Narrow:
    """The float8 E5M2 whose code is in the low 8 bits."""
    return Narrow(E5M2, int(bits) & E5M2.mask)


def bits_of(value: Narrow) -> np.uint32:
    """The code of a float16 or float8 number, the other bits 0."""
    return np.uint32(value.bits)


def fused(a: Any, b: Any, c: Any) -> Narrow:
    """a * b + c of three numbers of one format, of which one at least is `Narrow`, rounded once.

    Raises
    ------
    TypeError
        They are not of one format.
    """
    one = next(value for value in (a, b, c) if isinstance(value, Narrow))
    x, y, z = (one._same(value) for value in (a, b, c))
    if not all(math.isfinite(value) for value in (x, y, z)):
        return one._rounded(x * y + z)
    exact = Fraction(x) * Fraction(y) + Fraction(z)
    if exact == 0:  # a rational has no -0: binary64 gives the zero that IEEE 754 asks for
        return one._rounded(x * y + z)
    return Narrow(one.format, round_bits(one.format, exact))


FROM_NUMBER: Final[dict[Format, Callable[[Any], Narrow]]] = {F16: fp16, E4M3: fp8, E5M2: e5m2}
FROM_BITS: Final[dict[Format, Callable[[int], Narrow]]] = {
    F16: fp16_from_bits,
    E4M3: fp8_from_bits,
    E5M2: e5m2_from_bits,
}
