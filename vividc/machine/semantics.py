"""What every operation computes on 32-bit words: the single definition of operation semantics.

The interpreter and the cycle simulator both read this table; numba and numpy are the independent
oracle.

Integers wrap modulo 2**32 and shift amounts count modulo 32. Floating point is IEEE 754-2019
binary32, round to nearest even, with subnormals; every *arithmetic* NaN result is the canonical
quiet NaN 0x7FC00000, while `fneg`, `fabs`, `mov` and `select` are bit operations and keep a NaN's
payload. `fmin` and `fmax` are IEEE 754-2019 minimumNumber and maximumNumber: a NaN loses against a
number, and -0 is smaller than +0. `fptosi` truncates, saturates, and turns NaN into 0.

Results are computed in binary64 and rounded once: sums and differences of binary32 numbers survive
the double rounding (Figueroa, "When is double rounding innocuous?", 1995), products are exact in
binary64, and `fma`, `fms` and `fnma` round their binary64 sum to odd first (Boldo and Melquiond,
"Emulation of FMA and correctly rounded sums: proved algorithms using rounding to odd", 2008).
Operations on numbers of 16 and 8 bits are in `machine.lane_semantics`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from struct import Struct
from typing import Final

from vividc.errors import InternalError
from vividc.machine.elementary import ELEMENTARY_SEMANTICS
from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import Opcode
from vividc.machine.words import (
    CANONICAL_NAN,
    INFINITY,
    INT_MAX,
    SIGN_BIT,
    WORD_MASK,
    float_of,
    signed,
    word_of,
)

_TWO_31: Final = 2147483648.0

# Native ("@") packing is a plain C conversion.
_pack_words2 = Struct("@II").pack
_pack_words3 = Struct("@III").pack
_unpack_floats2 = Struct("@ff").unpack
_unpack_floats3 = Struct("@fff").unpack
_pack_double = Struct("@d").pack
_unpack_double = Struct("@d").unpack
_pack_bits = Struct("@q").pack
_unpack_bits = Struct("@q").unpack


def evaluate(op: Opcode, operands: Sequence[int]) -> int:
    """Result word of `op` on operand words.

    Parameters
    ----------
    op
        An operation of the table: not a source, a memory access, a live-out or a generic node.
    operands
        One word (0 .. 2**32-1) per operand port; predicates are 0 or 1.

    Raises
    ------
    InternalError
        `op` has no value of its own.
    """
    function = SEMANTICS.get(op)
    if function is None:
        raise InternalError(f"{op.value} has no semantics of its own")
    return function(*operands)


def evaluate_predicated(op: Opcode, pred: int, operands: Sequence[int]) -> int:
    """Result of a predicated operation: the last operand passes through where `pred` is 0."""
    return evaluate(op, operands) if pred else operands[-1]


def _mov(a: int) -> int:
    return a


def _add(a: int, b: int) -> int:
    return (a + b) & WORD_MASK


def _sub(a: int, b: int) -> int:
    return (a - b) & WORD_MASK


def _mul(a: int, b: int) -> int:
    return (a * b) & WORD_MASK


def _mulhs(a: int, b: int) -> int:
    return (signed(a) * signed(b) >> 32) & WORD_MASK


def _mulhu(a: int, b: int) -> int:
    return a * b >> 32


def _and(a: int, b: int) -> int:
    return a & b


def _or(a: int, b: int) -> int:
    return a | b


def _xor(a: int, b: int) -> int:
    return a ^ b


def _shl(a: int, b: int) -> int:
    return (a << (b & 31)) & WORD_MASK


def _lshr(a: int, b: int) -> int:
    return a >> (b & 31)


def _ashr(a: int, b: int) -> int:
    return (signed(a) >> (b & 31)) & WORD_MASK


# Flipping the sign bit maps the signed order onto the unsigned one.
def _smin(a: int, b: int) -> int:
    return a if a ^ SIGN_BIT <= b ^ SIGN_BIT else b


def _smax(a: int, b: int) -> int:
    return a if a ^ SIGN_BIT >= b ^ SIGN_BIT else b


def _icmp_eq(a: int, b: int) -> int:
    return 1 if a == b else 0


def _icmp_ne(a: int, b: int) -> int:
    return 1 if a != b else 0


def _icmp_slt(a: int, b: int) -> int:
    return 1 if a ^ SIGN_BIT < b ^ SIGN_BIT else 0


def _icmp_sle(a: int, b: int) -> int:
    return 1 if a ^ SIGN_BIT <= b ^ SIGN_BIT else 0


def _icmp_ult(a: int, b: int) -> int:
    return 1 if a < b else 0


def _icmp_ule(a: int, b: int) -> int:
    return 1 if a <= b else 0


def _select(p: int, a: int, b: int) -> int:
    return a if p else b


def _fadd(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return word_of(x + y)


def _fsub(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return word_of(x - y)


def _fmul(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return word_of(x * y)


def _fma(a: int, b: int, c: int) -> int:
    x, y, z = _unpack_floats3(_pack_words3(a, b, c))
    product = x * y  # exact: 24 + 24 bits
    total = product + z
    # TwoSum (Knuth, TAOCP vol. 2, 4.2.2): total + error is the exact sum.
    virtual = total - product
    error = (product - (total - virtual)) + (z - virtual)
    if error != 0.0 and error == error:  # noqa: PLR0124 - NaN if anything is infinite
        total = _rounded_to_odd(total, error)
    return word_of(total)


def _fms(a: int, b: int, c: int) -> int:
    return _fma(a, b, c ^ SIGN_BIT)


def _fnma(a: int, b: int, c: int) -> int:
    return _fma(a ^ SIGN_BIT, b, c)


def _rounded_to_odd(total: float, error: float) -> float:
    bits: int = _unpack_bits(_pack_double(total))[0]
    if bits & 1:
        return total
    bits += 1 if (error > 0.0) == (total > 0.0) else -1
    odd: float = _unpack_double(_pack_bits(bits))[0]
    return odd


def _fneg(a: int) -> int:
    return a ^ SIGN_BIT


def _fabs(a: int) -> int:
    return a & INT_MAX


def _fmin(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    if x < y:
        return a
    if y < x:
        return b
    return _min_max_of_unordered(a, b, x, y, a | b)


def _fmax(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    if x > y:
        return a
    if y > x:
        return b
    return _min_max_of_unordered(a, b, x, y, a & b)


def _min_max_of_unordered(a: int, b: int, x: float, y: float, if_equal: int) -> int:
    if x == y:  # equal numbers share all bits but the sign of zero
        return if_equal
    if not math.isnan(y):
        return b
    return CANONICAL_NAN if math.isnan(x) else a


def _fcmp_oeq(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 1 if x == y else 0


def _fcmp_une(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 1 if x != y else 0


def _fcmp_olt(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 1 if x < y else 0


def _fcmp_ole(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 1 if x <= y else 0


def _fcmp_ult(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 0 if x >= y else 1


def _fcmp_ule(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 0 if x > y else 1


def _fcmp_one(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 1 if x < y or x > y else 0


def _fcmp_ueq(a: int, b: int) -> int:
    x, y = _unpack_floats2(_pack_words2(a, b))
    return 0 if x < y or x > y else 1


def _fcmp_ord(a: int, b: int) -> int:
    return 0 if _fcmp_uno(a, b) else 1


def _fcmp_uno(a: int, b: int) -> int:
    return 1 if a & INT_MAX > INFINITY or b & INT_MAX > INFINITY else 0


def _sitofp(a: int) -> int:
    return word_of(float(signed(a)))


def _uitofp(a: int) -> int:
    return word_of(float(a))


def _fptosi(a: int) -> int:
    x = float_of(a)
    if -_TWO_31 < x < _TWO_31:
        return int(x) & WORD_MASK
    if math.isnan(x):
        return 0
    return SIGN_BIT if x < 0.0 else INT_MAX


SEMANTICS: Final[dict[Opcode, Callable[..., int]]] = {
    Opcode.MOV: _mov,
    Opcode.ADD: _add,
    Opcode.SUB: _sub,
    Opcode.MUL: _mul,
    Opcode.MULHS: _mulhs,
    Opcode.MULHU: _mulhu,
    Opcode.AND: _and,
    Opcode.OR: _or,
    Opcode.XOR: _xor,
    Opcode.SHL: _shl,
    Opcode.LSHR: _lshr,
    Opcode.ASHR: _ashr,
    Opcode.SMIN: _smin,
    Opcode.SMAX: _smax,
    Opcode.ICMP_EQ: _icmp_eq,
    Opcode.ICMP_NE: _icmp_ne,
    Opcode.ICMP_SLT: _icmp_slt,
    Opcode.ICMP_SLE: _icmp_sle,
    Opcode.ICMP_ULT: _icmp_ult,
    Opcode.ICMP_ULE: _icmp_ule,
    Opcode.SELECT: _select,
    Opcode.FADD: _fadd,
    Opcode.FSUB: _fsub,
    Opcode.FMUL: _fmul,
    Opcode.FMA: _fma,
    Opcode.FMS: _fms,
    Opcode.FNMA: _fnma,
    Opcode.FNEG: _fneg,
    Opcode.FABS: _fabs,
    Opcode.FMIN: _fmin,
    Opcode.FMAX: _fmax,
    Opcode.FCMP_OEQ: _fcmp_oeq,
    Opcode.FCMP_UNE: _fcmp_une,
    Opcode.FCMP_OLT: _fcmp_olt,
    Opcode.FCMP_OLE: _fcmp_ole,
    Opcode.FCMP_ULT: _fcmp_ult,
    Opcode.FCMP_ULE: _fcmp_ule,
    Opcode.FCMP_ONE: _fcmp_one,
    Opcode.FCMP_UEQ: _fcmp_ueq,
    Opcode.FCMP_ORD: _fcmp_ord,
    Opcode.FCMP_UNO: _fcmp_uno,
    Opcode.SITOFP: _sitofp,
    Opcode.UITOFP: _uitofp,
    Opcode.FPTOSI: _fptosi,
    **LANE_SEMANTICS,
    **ELEMENTARY_SEMANTICS,
}
