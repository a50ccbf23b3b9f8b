"""What the host computes for float16 and float8: the operations of `numba_types` for numba's CPU.

Operands are codes in uint32. A sum or product of two numbers of such a format is exact in binary64;
so is the rounding of a * b + c in binary64 wherever it could matter: c is below half a last place
of the product only if the product has more than 53 bits down to c, which takes an exponent beyond
every format's overflow. The result is then rounded once to the format.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numba.extending import register_jitable

from vividc.formats import E4M3, E5M2, F16, Format

_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable
_TO_INTEGER: Final = 2.0**52
"""Added to and taken from a smaller number, it rounds it to an integer, ties to even."""


def _decoder(fmt: Format) -> Callable[..., Any]:
    """Value of a code in binary64."""
    mantissa_bits, field_mask = fmt.mantissa_bits, (1 << fmt.exponent_bits) - 1
    mantissa_mask, implicit = (1 << fmt.mantissa_bits) - 1, 1 << fmt.mantissa_bits
    lowest = fmt.min_exponent - fmt.mantissa_bits
    sign, overflow, infinite = fmt.sign, fmt.overflow, fmt.has_infinity

    @_helper
    def decoded(code: Any) -> Any:
        magnitude: Any = np.int64(code) & (sign - 1)
        if magnitude > overflow:
            return math.nan
        if infinite and magnitude == overflow:
            value = math.inf
        else:
            field = (magnitude >> mantissa_bits) & field_mask
            mantissa = magnitude & mantissa_mask
            if field > 0:
                mantissa |= implicit
            value = math.ldexp(np.float64(mantissa), lowest - 1 + (field if field > 0 else 1))
        return -value if np.int64(code) & sign else value

    return decoded


def _encoder(fmt: Format) -> Callable[..., Any]:
    """Code of a value in binary64, rounded to nearest even."""
    mantissa_bits, min_exponent = fmt.mantissa_bits, fmt.min_exponent
    sign, overflow, nan = fmt.sign, fmt.overflow, fmt.nan
    min_normal, beyond = math.ldexp(1.0, fmt.min_exponent), 2.0 * fmt.max_finite

    @_helper
    def magnitude_code(magnitude: Any) -> Any:
        if magnitude >= beyond:
            return np.int64(overflow)
        exponent: Any = np.int64(min_exponent)
        if magnitude >= min_normal:
            exponent = np.int64(math.frexp(magnitude)[1]) - 1
        scaled = math.ldexp(magnitude, mantissa_bits - exponent)
        rounded = np.int64((scaled + _TO_INTEGER) - _TO_INTEGER)
        code = rounded + ((exponent - min_exponent) << mantissa_bits)
        return code if code < overflow else np.int64(overflow)

    @_helper
    def encoded(value: Any) -> Any:
        if value != value:  # noqa: PLR0124 - math.isnan is a call for the host, too
            return np.uint32(nan)
        code = magnitude_code(abs(value))
        if math.copysign(1.0, value) < 0.0:
            code |= sign
        return np.uint32(code)

    return encoded


def _operations(fmt: Format) -> dict[str, Callable[..., Any]]:
    """The operations of a format, by name."""
    decoded, encoded = _decoder(fmt), _encoder(fmt)

    def to_f32(a: Any) -> Any:
        return np.float32(decoded(a))

    def from_f32(x: Any) -> Any:
        return encoded(np.float64(x))

    def add(a: Any, b: Any) -> Any:
        return encoded(decoded(a) + decoded(b))

    def sub(a: Any, b: Any) -> Any:
        return encoded(decoded(a) - decoded(b))

    def mul(a: Any, b: Any) -> Any:
        return encoded(decoded(a) * decoded(b))

    def fma(a: Any, b: Any, c: Any) -> Any:
        return encoded(decoded(a) * decoded(b) + decoded(c))

    made = (to_f32, from_f32, add, sub, mul, fma)
    return {function.__name__: function for function in made}


def _larger(fmt: Format) -> Callable[..., Any]:
    """The larger of two codes as `fmax` has it."""
    decoded, nan = _decoder(fmt), np.uint32(fmt.nan)

    @_helper
    def larger(a: Any, b: Any) -> Any:
        x, y = decoded(a), decoded(b)
        if x == y:  # equal numbers share all bits but the sign of zero
            return a & b
        if y != y:  # noqa: PLR0124 - math.isnan is a call for the host, too
            return a if x == x else nan  # noqa: PLR0124
        return b if not x > y else a

    return larger


def _on_words(fmt: Format) -> dict[str, Callable[..., Any]]:
    """The operations on words of several numbers, by name."""
    decoded, encoded, larger = _decoder(fmt), _encoder(fmt), _larger(fmt)
    bits, half, mask = np.uint32(fmt.bits), np.uint32(16), np.uint32(fmt.mask)
    lanes, low_half = fmt.lanes, np.uint32(0xFFFF)

    @_helper
    def pack(x: Any, y: Any) -> Any:
        return encoded(np.float64(x)) | encoded(np.float64(y)) << bits

    def pack_high(x: Any, y: Any, low: Any) -> Any:
        return pack(x, y) << half | np.uint32(low) & low_half

    def dot(a: Any, b: Any, total: Any) -> Any:
        result = np.float32(total)
        for lane in range(lanes):
            x, y = (a >> np.uint32(bits * lane)) & mask, (b >> np.uint32(bits * lane)) & mask
            # Exact but for the last rounding: 53 bits are more than twice 24.
            result = np.float32(decoded(x) * decoded(y) + np.float64(result))
        return result

    def lanes_max(a: Any, b: Any) -> Any:
        word = np.uint32(0)
        for lane in range(lanes):
            shift = np.uint32(bits * lane)
            word |= np.uint32(larger((a >> shift) & mask, (b >> shift) & mask) << shift)
        return word

    made = (pack, pack_high, dot, lanes_max)
    return {function.__name__: function for function in made}


HOST: Final = {fmt: _operations(fmt) | _on_words(fmt) for fmt in (F16, E4M3, E5M2)}
"""The operations of each format."""
