"""Multiply-adds of many PEs at once, as LLVM IR on vectors of words.

Numbers of 16 and 8 bits become floats by moving their bits into place and multiplying by a power of
two, which is exact, of subnormal numbers too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from vividc.formats import E4M3, E5M2, F16, Format
from vividc.machine.opcodes import Opcode
from vividc.machine.words import CANONICAL_NAN, INT_MAX, SIGN_BIT
from vividc.sim.native.bulk.tables import LANES
from vividc.sim.native.write.text import Code

WORDS: Final = f"<{LANES} x i32>"
FLOATS: Final = f"<{LANES} x float>"
FLAGS: Final = f"<{LANES} x i1>"

VECTOR_DECLARATIONS: Final = (
    f"declare {FLOATS} @llvm.fma.v{LANES}f32({FLOATS}, {FLOATS}, {FLOATS})\n"
)

_FORMATS: Final = {
    Opcode.DOT_F16X2: F16,
    Opcode.DOT_E4M3X4: E4M3,
    Opcode.DOT_E5M2X4: E5M2,
}
_MANTISSA_BITS: Final = 23
_BIAS: Final = 127


def multiply_add(code: Code, op: Opcode, words: Sequence[str]) -> str:
    """The sum, with the products of the operands' lanes added one after the other."""
    x, y, total = words
    total = code.value(f"bitcast {WORDS} {total} to {FLOATS}")
    if op is Opcode.FMA:
        pairs = [(_floats(code, x), _floats(code, y))]
    else:
        fmt = _FORMATS[op]
        pairs = [
            (_lane(code, fmt, x, lane), _lane(code, fmt, y, lane)) for lane in range(fmt.lanes)
        ]
    for left, right in pairs:
        # A product of two narrow numbers is exact: fused or not is the same.
        arguments = f"{FLOATS} {left}, {FLOATS} {right}, {FLOATS} {total}"
        total = code.value(f"call {FLOATS} @llvm.fma.v{LANES}f32({arguments})")
    is_nan = code.value(f"fcmp uno {FLOATS} {total}, {total}")
    bits = code.value(f"bitcast {FLOATS} {total} to {WORDS}")
    return _choose(code, is_nan, str(CANONICAL_NAN), bits)


def splat(word: str) -> str:
    """A vector of equal words."""
    return "<" + ", ".join([f"i32 {word}"] * LANES) + ">"


def _floats(code: Code, words: str) -> str:
    return code.value(f"bitcast {WORDS} {words} to {FLOATS}")


def _choose(code: Code, condition: str, word: str, others: str) -> str:
    return code.value(f"select {FLAGS} {condition}, {WORDS} {splat(word)}, {WORDS} {others}")


def _with(code: Code, name: str, words: str, number: int) -> str:
    return code.value(f"{name} {WORDS} {words}, {splat(str(number))}")


def _lane(code: Code, fmt: Format, words: str, lane: int) -> str:
    """The numbers in a lane of each word, as floats."""
    if lane:
        words = _with(code, "lshr", words, fmt.bits * lane)
    magnitude = _with(code, "and", words, fmt.sign - 1)
    raised = _with(code, "shl", magnitude, _MANTISSA_BITS - fmt.mantissa_bits)
    power = code.value(
        f"bitcast {WORDS} {splat(str((2 * _BIAS - fmt.bias) << _MANTISSA_BITS))} to {FLOATS}"
    )
    number = code.value(f"fmul {FLOATS} {_floats(code, raised)}, {power}")
    bits = code.value(f"bitcast {FLOATS} {number} to {WORDS}")
    if fmt.has_infinity:
        is_infinite = code.value(f"icmp eq {WORDS} {magnitude}, {splat(str(fmt.infinity))}")
        bits = _choose(code, is_infinite, str(0xFF << _MANTISSA_BITS), bits)
    largest = fmt.infinity if fmt.has_infinity else fmt.nan - 1
    is_nan = code.value(f"icmp ugt {WORDS} {magnitude}, {splat(str(largest))}")
    bits = _choose(code, is_nan, str(CANONICAL_NAN), bits)
    sign = _with(code, "shl", words, 32 - fmt.bits)
    sign = _with(code, "and", sign, SIGN_BIT - (INT_MAX + 1) * 2)
    return _floats(code, code.value(f"or {WORDS} {bits}, {sign}"))
