"""Bit counts and permutations in operations of the array: exact.

Sources: Warren, Hacker's Delight (2003), chapters 5 and 7; the counts of zeros read the exponent
that a conversion to binary32 finds.
"""

from __future__ import annotations

from typing import Final

from vividc.dfg.expand.builder import EXPONENT_SHIFT, Builder, Expansion
from vividc.dfg.passes.rewrite import Value
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK

_ODD_BITS: Final = 0x55555555
_PAIRS: Final = 0x33333333
_NIBBLES: Final = 0x0F0F0F0F
_BYTES: Final = 0x01010101
_TOP_BYTE: Final = 24
_BIAS: Final = 127


def count_ones(b: Builder, x: Value) -> Value:
    """Bits that are set, in 12 operations: sums of 2, 4 and 8 bits side by side, and a product that
    adds the bytes.
    """
    pairs = b.op(Opcode.SUB, x, b.op(Opcode.AND, b.op(Opcode.LSHR, x, 1), _ODD_BITS))
    high = b.op(Opcode.AND, b.op(Opcode.LSHR, pairs, 2), _PAIRS)
    nibbles = b.op(Opcode.ADD, b.op(Opcode.AND, pairs, _PAIRS), high)
    total = b.op(Opcode.ADD, nibbles, b.op(Opcode.LSHR, nibbles, 4))
    byte_sums = b.op(Opcode.AND, total, _NIBBLES)
    return b.op(Opcode.LSHR, b.op(Opcode.MUL, byte_sums, _BYTES), _TOP_BYTE)


def leading_zeros(b: Builder, x: Value) -> Value:
    """Zeros above the highest set bit, in 7 operations; 32 for 0.

    Without the bits below a set one the conversion cannot round up to the next power of two.
    """
    half = b.op(Opcode.LSHR, x, 1)
    sparse = b.op(Opcode.AND, x, b.op(Opcode.XOR, half, WORD_MASK))
    exponent = b.op(Opcode.LSHR, b.op(Opcode.UITOFP, sparse), EXPONENT_SHIFT)
    zeros = b.op(Opcode.SUB, _BIAS + WORD_BITS - 1, exponent)
    return b.op(Opcode.SMIN, zeros, WORD_BITS)


def trailing_zeros(b: Builder, x: Value) -> Value:
    """Zeros below the lowest set bit, in 7 operations; 32 for 0."""
    lowest = b.op(Opcode.AND, x, b.op(Opcode.SUB, 0, x))
    exponent = b.op(Opcode.LSHR, b.op(Opcode.UITOFP, lowest), EXPONENT_SHIFT)
    zeros = b.op(Opcode.SUB, exponent, _BIAS)
    return b.op(Opcode.SELECT, b.op(Opcode.ICMP_NE, x, 0), zeros, WORD_BITS)


def swap_bytes(b: Builder, x: Value) -> Value:
    """The bytes in reverse order, in 9 operations, 4 deep."""
    ends = b.op(Opcode.OR, b.op(Opcode.SHL, x, 24), b.op(Opcode.LSHR, x, 24))
    up = b.op(Opcode.SHL, b.op(Opcode.AND, x, 0xFF00), 8)
    down = b.op(Opcode.AND, b.op(Opcode.LSHR, x, 8), 0xFF00)
    return b.op(Opcode.OR, ends, b.op(Opcode.OR, up, down))


def reverse_bits(b: Builder, x: Value) -> Value:
    """The bits in reverse order, in 24 operations: neighbours, pairs and nibbles change places, and
    then the bytes.
    """
    for amount, mask in ((1, _ODD_BITS), (2, _PAIRS), (4, _NIBBLES)):
        down = b.op(Opcode.AND, b.op(Opcode.LSHR, x, amount), mask)
        x = b.op(Opcode.OR, b.op(Opcode.SHL, b.op(Opcode.AND, x, mask), amount), down)
    return swap_bytes(b, x)


EXPANSIONS: Final[dict[Opcode, Expansion]] = {
    Opcode.CTPOP: count_ones,
    Opcode.CTLZ: leading_zeros,
    Opcode.CTTZ: trailing_zeros,
    Opcode.BSWAP: swap_bytes,
    Opcode.BITREVERSE: reverse_bits,
}
