"""Number formats of less than 32 bits: what their codes mean and how they round, defined once.

`F16` is IEEE 754 binary16. `E4M3` and `E5M2` are the 8-bit formats of the OCP 8-bit Floating Point
Specification, revision 1.0 (2023): E4M3 has no infinity and one NaN of each sign, E5M2 is laid out
as IEEE 754 would. `docs/formats.md` tells the rules; they are few:

- A value is rounded once, to nearest even, subnormals included.
- What is too large becomes infinity where the format has one (F16, E5M2), else the largest finite
  number (E4M3, which so never makes a NaN of a number). "Too large" is what would round to more
  than the largest finite number if the exponent had no limit.
- Every NaN that is computed is the canonical one, positive and quiet.

A *code* is the number's bits as an integer; a *word* holds `Format.lanes` codes, lane 0 lowest. A
scalar is a word whose lanes but the lowest are 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt

_WORD_BITS: Final = 32
_BYTE_BITS: Final = 8

Codes = npt.NDArray[np.unsignedinteger[Any]]


@dataclass(frozen=True, slots=True)
class Format:
    """A binary floating-point format: a sign, a biased exponent, and a mantissa.

    Attributes
    ----------
    name
        As in the names of operations.
    exponent_bits, mantissa_bits
        Widths of the fields; the sign takes one bit more.
    has_infinity
        The largest exponent holds infinity and NaNs, as in IEEE 754; else it holds numbers, but for
        the code of all ones, which is NaN, and what is too large saturates.
    """

    name: str
    exponent_bits: int
    mantissa_bits: int
    has_infinity: bool

    @property
    def bits(self) -> int:
        """Width of a code."""
        return 1 + self.exponent_bits + self.mantissa_bits

    @property
    def lanes(self) -> int:
        """Codes in a word."""
        return _WORD_BITS // self.bits

    @property
    def bias(self) -> int:
        """What the exponent field is too large by."""
        return (1 << (self.exponent_bits - 1)) - 1

    @property
    def min_exponent(self) -> int:
        """Exponent of the smallest normal number, and of the subnormal ones."""
        return 1 - self.bias

    @property
    def mask(self) -> int:
        """All bits of a code."""
        return (1 << self.bits) - 1

    @property
    def sign(self) -> int:
        """The sign bit of a code."""
        return 1 << (self.bits - 1)

    @property
    def infinity(self) -> int | None:
        """Code of positive infinity."""
        return self.max_code + 1 if self.has_infinity else None

    @property
    def max_code(self) -> int:
        """Code of the largest finite number."""
        if self.has_infinity:
            return (((1 << self.exponent_bits) - 1) << self.mantissa_bits) - 1
        return self.sign - 2

    @property
    def overflow(self) -> int:
        """Code of what is too large: infinity, or the largest finite number."""
        return self.max_code + 1 if self.has_infinity else self.max_code

    @property
    def nan(self) -> int:
        """Code of the canonical NaN."""
        if self.has_infinity:
            return self.max_code + 1 | 1 << (self.mantissa_bits - 1)
        return self.sign - 1

    @property
    def saturates(self) -> bool:
        """Whether what is too large becomes the largest finite number."""
        return not self.has_infinity

    @property
    def max_finite(self) -> float:
        """The largest finite number."""
        return to_float(self, self.max_code)

    @property
    def min_normal(self) -> float:
        """The smallest positive normal number."""
        return math.ldexp(1.0, self.min_exponent)

    @property
    def min_subnormal(self) -> float:
        """The smallest positive number."""
        return math.ldexp(1.0, self.min_exponent - self.mantissa_bits)

    @property
    def epsilon(self) -> float:
        """The largest relative error of rounding to a normal number: half the last place of 1."""
        return math.ldexp(0.5, -self.mantissa_bits)

    @property
    def dtype(self) -> np.dtype[np.unsignedinteger[Any]]:
        """The numpy type of arrays of codes."""
        return np.dtype(np.uint8) if self.bits == _BYTE_BITS else np.dtype(np.uint16)


F16: Final = Format("f16", 5, 10, has_infinity=True)
E4M3: Final = Format("e4m3", 4, 3, has_infinity=False)
E5M2: Final = Format("e5m2", 5, 2, has_infinity=True)
FORMATS: Final = {fmt.name: fmt for fmt in (F16, E4M3, E5M2)}
"""Every format by its name."""


def round_bits(fmt: Format, value: float | Fraction) -> int:
    """Code of `value`, rounded once to nearest even.

    Parameters
    ----------
    value
        Any binary64 number, infinities and NaN included, or an exact rational (which has no
        negative zero).
    """
    if isinstance(value, Fraction):
        magnitude = _code_of_ratio(fmt, abs(value))
        return magnitude | fmt.sign if value < 0 else magnitude
    if value != value:  # noqa: PLR0124 - the NaN test, cheaper than math.isnan
        return fmt.nan
    if value == 0.0:
        return fmt.sign if math.copysign(1.0, value) < 0.0 else 0
    magnitude = _code_of_float(fmt, abs(value))
    return magnitude | fmt.sign if value < 0.0 else magnitude


def to_float(fmt: Format, code: int) -> float:
    """Value of a code: exact, as every format's numbers are binary32 and binary64 numbers."""
    return values(fmt)[code]


@cache
def values(fmt: Format) -> tuple[float, ...]:
    """Value of every code of a format."""
    return tuple(to_floats(fmt, np.arange(1 << fmt.bits, dtype=fmt.dtype)).tolist())


def round_array(fmt: Format, numbers: npt.NDArray[np.floating[Any]]) -> Codes:
    """Codes of many numbers, each as `round_bits` has it.

    Parameters
    ----------
    numbers
        binary16, binary32 or binary64 numbers of any shape.

    Returns
    -------
    Codes
        uint8 or uint16, `fmt.dtype`, of the same shape.
    """
    with np.errstate(invalid="ignore"):  # a signalling NaN is as good as any
        exact = np.asarray(numbers, np.float64)
    magnitude = np.abs(exact)
    finite = np.where(np.isfinite(magnitude), magnitude, 0.0)
    exponent = np.maximum(np.frexp(finite)[1] - 1, fmt.min_exponent)
    # As in `_code_of_float`; the exponent of 0 is of no consequence.
    scaled = np.rint(np.ldexp(finite, fmt.mantissa_bits - exponent)).astype(np.int64)
    code = scaled + ((exponent.astype(np.int64) - fmt.min_exponent) << fmt.mantissa_bits)
    code = np.where(finite == 0.0, 0, np.minimum(code, fmt.overflow))
    code = np.where(np.isinf(magnitude), fmt.overflow, code)
    code = code | np.where(np.signbit(exact), fmt.sign, 0)
    return np.where(np.isnan(exact), fmt.nan, code).astype(fmt.dtype)


def to_floats(fmt: Format, codes: Codes) -> npt.NDArray[np.float32]:
    """Values of many codes, as binary32: exact; every NaN is the canonical one."""
    code = np.asarray(codes).astype(np.int64)
    field = code >> fmt.mantissa_bits & (1 << fmt.exponent_bits) - 1
    mantissa = code & (1 << fmt.mantissa_bits) - 1
    significand = np.where(field == 0, mantissa, mantissa | 1 << fmt.mantissa_bits)
    exponent = np.maximum(field, 1) - fmt.bias - fmt.mantissa_bits
    value = np.ldexp(significand.astype(np.float64), exponent)
    magnitude = code & fmt.sign - 1
    if fmt.has_infinity:
        value = np.where(magnitude == fmt.overflow, np.inf, value)
    value = np.where(code & fmt.sign, -value, value)
    value = np.where(magnitude > fmt.overflow, np.nan, value)
    return value.astype(np.float32)


def nearest(fmt: Format, numbers: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return for many finite numbers the nearest that a format has: what `to_floats` makes of
    `round_array`, in a fifth of the time.
    """
    most = np.float32(2 * fmt.max_finite)
    within = np.clip(numbers, -most, most)
    exponent = np.maximum(np.frexp(within)[1] - 1, fmt.min_exponent) - fmt.mantissa_bits
    found = np.ldexp(np.rint(np.ldexp(within, -exponent)), exponent)
    beyond = np.float32(np.inf if fmt.has_infinity else fmt.max_finite)
    is_beyond = np.abs(found) > fmt.max_finite
    kept: npt.NDArray[np.float32] = np.where(is_beyond, np.copysign(beyond, found), found)
    return kept


def split(fmt: Format, word: int) -> tuple[int, ...]:
    """Codes of a word's lanes, lane 0 first."""
    return tuple(word >> fmt.bits * lane & fmt.mask for lane in range(fmt.lanes))


def join(fmt: Format, codes: Sequence[int]) -> int:
    """The word whose lanes hold these codes, lane 0 first; further lanes are 0."""
    return sum(code << fmt.bits * lane for lane, code in enumerate(codes))


def _code_of_float(fmt: Format, magnitude: float) -> int:
    """A positive number in units of its last place, and the exponent field added to that: a carry
    out of the significand raises the exponent, and a subnormal one has none to add.
    """
    if magnitude == math.inf:
        return fmt.overflow
    exponent = max(math.frexp(magnitude)[1] - 1, fmt.min_exponent)
    scaled = round(math.ldexp(magnitude, fmt.mantissa_bits - exponent))
    code = scaled + ((exponent - fmt.min_exponent) << fmt.mantissa_bits)
    return min(code, fmt.overflow)


def _code_of_ratio(fmt: Format, magnitude: Fraction) -> int:
    """`_code_of_float` of an exact number."""
    if magnitude == 0:
        return 0
    exponent = magnitude.numerator.bit_length() - magnitude.denominator.bit_length()
    if magnitude < Fraction(2) ** exponent:
        exponent -= 1
    exponent = max(exponent, fmt.min_exponent)
    scaled = round(magnitude / Fraction(2) ** (exponent - fmt.mantissa_bits))
    code = scaled + ((exponent - fmt.min_exponent) << fmt.mantissa_bits)
    return min(code, fmt.overflow)
