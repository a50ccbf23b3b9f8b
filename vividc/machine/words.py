"""Machine words: 32 bits as an integer 0 .. 2**32-1, read as signed, as binary32, or as bits."""

from __future__ import annotations

from struct import Struct
from typing import Final

WORD_BITS: Final = 32
WORD_BYTES: Final = 4
WORD_MASK: Final = 0xFFFFFFFF
SIGN_BIT: Final = 0x80000000
CANONICAL_NAN: Final = 0x7FC00000
INT_MAX: Final = 0x7FFFFFFF
INFINITY: Final = 0x7F800000
_MASKS: Final = {1: 0xFF, 2: 0xFFFF}  # of the bytes of a narrow access

# Native ("@") packing of `f` is a plain C conversion: it rounds to nearest even and overflows to
# infinity, where the standard-size formats raise OverflowError.
_pack_word = Struct("@I").pack
_unpack_word = Struct("@I").unpack
_pack_float = Struct("@f").pack
_unpack_float = Struct("@f").unpack


def float_of(word: int) -> float:
    """Value of the binary32 number with these bits, as a Python float."""
    value: float = _unpack_float(_pack_word(word))[0]
    return value


def word_of(value: float) -> int:
    """Bits of `value` rounded to binary32 (nearest even, overflow to infinity, NaN canonical)."""
    if value != value:  # noqa: PLR0124 - the NaN test, cheaper than math.isnan
        return CANONICAL_NAN
    word: int = _unpack_word(_pack_float(value))[0]
    return word


def signed(word: int) -> int:
    """Two's complement value of the low 32 bits."""
    return (word & WORD_MASK) - ((word & SIGN_BIT) << 1)


def loaded(word: int, byte: int, width: int, is_signed: bool) -> int:
    """What a load of `width` bytes at byte address `byte` gives, if `word` is the memory's word
    there.
    """
    if width == WORD_BYTES:
        return word
    low = word >> _lane(byte) & _MASKS[width]
    sign = 1 << 8 * width - 1
    return low | WORD_MASK ^ _MASKS[width] if is_signed and low & sign else low


def stored(word: int, value: int, byte: int, width: int) -> int:
    """The memory's word after a store of `value`'s low `width` bytes at byte address `byte`."""
    if width == WORD_BYTES:
        return value
    lane, mask = _lane(byte), _MASKS[width]
    return word & ~(mask << lane) | (value & mask) << lane


def _lane(byte: int) -> int:
    """Lowest bit in its word of the byte at this address."""
    return byte % WORD_BYTES * 8
