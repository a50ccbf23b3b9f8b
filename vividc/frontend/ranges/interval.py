"""Interval arithmetic on integers of a fixed width: what the range analysis computes with."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from vividc.ssa.ir import Instr, Kind

Interval = tuple[int, int]
BOTTOM: Interval = (1, 0)  # no value: not reached (yet)

S32: Interval = (-(2**31), 2**31 - 1)
U32: Interval = (0, 2**32 - 1)
_BOOL: Interval = (0, 1)
_WORD = 32
_TYPES = re.compile(r"(\.[if]\d+)+$")
_LOW = (0, -1, -(2**15), -(2**31), -(2**32), -(2**63))
_HIGH = (-1, 0, 1, 2**13, 2**15, 2**31 - 2, 2**31 - 1, 2**32 - 1, 2**63 - 1)
_CONVERTED: dict[str, Interval] = {"fptosi": S32, "fptoui": U32}


@cache
def width(type_: Kind) -> int:
    """Bits of an integer type."""
    return int(str(type_)[1:])


@cache
def is_integer(type_: Kind) -> bool:
    """Whether a type is one of integers."""
    return str(type_)[:1] == "i" and str(type_)[1:].isdigit()


@cache
def full(type_: Kind) -> Interval:
    """All values of an integer type; types of less than a word are taken as unsigned."""
    bits = width(type_)
    return (0, 2**bits - 1) if bits < _WORD else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def contains(outer: Interval, inner: Interval) -> bool:
    """Whether every value of `inner` is in `outer`."""
    return inner == BOTTOM or (outer[0] <= inner[0] and inner[1] <= outer[1])


def union(a: Interval, b: Interval) -> Interval:
    """The smallest interval with both."""
    if a == BOTTOM:
        return b
    if b == BOTTOM:
        return a
    return (min(a[0], b[0]), max(a[1], b[1]))


def intersect(a: Interval, b: Interval) -> Interval:
    """The values in both."""
    low, high = max(a[0], b[0]), min(a[1], b[1])
    return (low, high) if low <= high else BOTTOM


def widen(old: Interval, new: Interval, type_: Kind) -> Interval:
    """Move a bound that grew to the next of a few fixed ones, so that the analysis ends."""
    if BOTTOM in (old, new):
        return new
    low, high = new
    if low < old[0]:
        low = next(bound for bound in (*_LOW, full(type_)[0], low) if bound <= low)
    if high > old[1]:
        high = next(bound for bound in (*_HIGH, high) if bound >= high)
    return intersect((low, high), full(type_))


def compare(pred: str, a: Interval, b: Interval) -> bool | None:
    """Outcome of an integer comparison if it is the same for all values."""
    if BOTTOM in (a, b):
        return None
    if pred in ("eq", "ne"):
        if intersect(a, b) == BOTTOM:
            return pred == "ne"
        return (pred == "eq") if a == b and a[0] == a[1] else None
    if pred[0] == "u":
        if a[0] < 0 or b[0] < 0:
            return None
        pred = "s" + pred[1:]
    if pred in ("sgt", "sge"):
        a, b, pred = b, a, {"sgt": "slt", "sge": "sle"}[pred]
    slack = 1 if pred == "slt" else 0
    if a[1] + slack <= b[0]:
        return True
    return False if a[0] + slack > b[1] else None


def refine(a: Interval, pred: str, b: Interval) -> Interval:
    """Values of `a` that can satisfy `a pred b`."""
    if BOTTOM in (a, b):
        return a
    if pred[0] == "u":
        return _refine_unsigned(a, pred, b)
    if pred == "eq":
        return intersect(a, b)
    if pred == "ne":
        return _without(a, b)
    slack = 1 if pred in ("slt", "sgt") else 0
    if pred in ("slt", "sle"):
        return intersect(a, (a[0], b[1] - slack))
    return intersect(a, (b[0] + slack, a[1]))


def _refine_unsigned(a: Interval, pred: str, b: Interval) -> Interval:
    if b[0] < 0:
        return a
    slack = 1 if pred in ("ult", "ugt") else 0
    if pred in ("ult", "ule"):  # an unsigned value below a non-negative one is not negative either
        return intersect(a, (0, b[1] - slack))
    return intersect(a, (b[0] + slack, a[1])) if a[0] >= 0 else a


def _without(a: Interval, b: Interval) -> Interval:
    if b[0] != b[1]:
        return a
    low = a[0] + 1 if a[0] == b[0] else a[0]
    high = a[1] - 1 if a[1] == b[0] else a[1]
    return (low, high) if low <= high else BOTTOM


def comparable(op: Instr) -> bool:
    """Whether intervals say anything about the comparison: not about pointers, nor signed ones of
    small types.
    """
    return is_integer(op.type) and not (width(op.type) < _WORD and op.pred[0] == "s")


def evaluate(op: Instr, operands: tuple[Interval, ...]) -> Interval:
    """Interval of an instruction's result from those of its operands."""
    if op.op in ("icmp", "fcmp"):
        decided = compare(op.pred, *operands) if op.op == "icmp" and comparable(op) else None
        return _BOOL if decided is None else (int(decided), int(decided))
    known = _regardless_of_operands(op)
    if known is not None:
        return known
    key = _name(op)
    if op.op in ("sext", "zext", "trunc"):
        return BOTTOM if BOTTOM in operands else _convert(op, operands[0])
    rule = _RULES.get(key)
    if rule is not None and BOTTOM in operands:
        return BOTTOM
    if key in _READ_AS_SIGNED and width(op.type) < _WORD:
        return _of_signed(op, operands)
    result = full(op.type) if rule is None else rule(op, *operands)
    return result if contains(full(op.type), result) else full(op.type)


def _regardless_of_operands(op: Instr) -> Interval | None:
    if op.op == "load" and op.signed:
        half = 1 << 8 * op.width - 1
        return (-half, half - 1)
    if op.op in _CONVERTED and width(op.type) > _WORD:
        return _CONVERTED[op.op]
    return None


def _name(op: Instr) -> str:
    """The operation, or the intrinsic without its types."""
    return _TYPES.sub("", op.pred) if op.op == "call" else op.mnemonic


def as_signed(interval: Interval, bits: int) -> Interval:
    """Values of an integer type of less than a word, which are kept without sign, as signed."""
    low, high = interval
    half = 2 ** (bits - 1)
    if high < half:
        return interval
    return (low - 2 * half, high - 2 * half) if low >= half else (-half, half - 1)


def _unsigned(interval: Interval, bits: int) -> Interval:
    """Signed values of a type of less than a word as they are kept: without sign."""
    low, high = interval
    if low < 0 <= high:
        return (0, 2**bits - 1)
    return (low + 2**bits, high + 2**bits) if low < 0 else interval


def _of_signed(op: Instr, operands: tuple[Interval, ...]) -> Interval:
    """A signed operation on a type of less than a word."""
    bits = width(op.type)
    key = _name(op)
    low, high = _RULES[key](op, *(as_signed(operand, bits) for operand in operands))
    if not contains((-(2 ** (bits - 1)), 2 ** (bits - 1)), (low, high)):
        return full(op.type)
    return _unsigned((low, high), bits)


def _convert(op: Instr, a: Interval) -> Interval:
    if op.op == "trunc":
        return a if contains(full(op.type), a) else full(op.type)
    if op.op == "sext":
        signed = as_signed(a, width(op.source)) if width(op.source) < _WORD else a
        return _unsigned(signed, width(op.type)) if width(op.type) < _WORD else signed
    if a[0] >= 0:
        return a
    modulus = 2 ** width(op.source)
    return (a[0] + modulus, a[1] + modulus) if a[1] < 0 else (0, modulus - 1)


def _mul(op: Instr, a: Interval, b: Interval) -> Interval:
    products = [x * y for x in a for y in b]
    return (min(products), max(products))


def _shl(op: Instr, a: Interval, b: Interval) -> Interval:
    if b[0] < 0 or b[1] >= width(op.type):
        return full(op.type)
    return _mul(op, a, (2 ** b[0], 2 ** b[1]))


def _lshr(op: Instr, a: Interval, b: Interval) -> Interval:
    if b[0] < 0:
        return full(op.type)
    if a[0] >= 0:
        return (a[0] >> b[1], a[1] >> b[0])
    return (0, (2 ** width(op.type) - 1) >> b[0]) if b[0] > 0 else full(op.type)


def _ashr(op: Instr, a: Interval, b: Interval) -> Interval:
    if b[0] < 0:
        return full(op.type)
    shifted = [x >> y for x in a for y in b]
    return (min(shifted), max(shifted))


def _bits(*intervals: Interval) -> int:
    """Bits, sign not counted, that hold every value of the intervals."""
    return max(max(x if x >= 0 else ~x for x in interval).bit_length() for interval in intervals)


def _bitwise(op: Instr, a: Interval, b: Interval) -> Interval:
    limit = 2 ** _bits(a, b)
    return (0, limit - 1) if a[0] >= 0 and b[0] >= 0 else (-limit, limit - 1)


def _and(op: Instr, a: Interval, b: Interval) -> Interval:
    highs = [interval[1] for interval in (a, b) if interval[0] >= 0]
    return (0, min(highs)) if highs else _bitwise(op, a, b)


def _umin(op: Instr, a: Interval, b: Interval) -> Interval:
    if a[0] >= 0 and b[0] >= 0:
        return (min(a[0], b[0]), min(a[1], b[1]))
    return _and(op, a, b) if max(a[0], b[0]) >= 0 else full(op.type)


def _umax(op: Instr, a: Interval, b: Interval) -> Interval:
    if a[0] >= 0 and b[0] >= 0:
        return (max(a[0], b[0]), max(a[1], b[1]))
    return full(op.type)


def _quotient(a: Interval, b: Interval, divide: Callable[[int, int], int]) -> list[int]:
    """Quotients at the corners: they are monotonous in the dividend, and in the divisor on either
    side of 0.
    """
    positive, negative = intersect(b, (1, max(b[1], 1))), intersect(b, (min(b[0], -1), -1))
    return [
        divide(x, y) for side in (positive, negative) if side != BOTTOM for x in a for y in side
    ]


def _toward_zero(x: int, y: int) -> int:
    return abs(x) // abs(y) * (1 if (x < 0) == (y < 0) else -1)


def _divide(op: Instr, a: Interval, b: Interval) -> Interval:
    """Also Python's, whose quotients by zero are 0."""
    if op.mnemonic[0] == "u" and (a[0] < 0 or b[0] < 0):
        return full(op.type)
    if "floor" in op.mnemonic:
        quotients = _quotient(a, b, lambda x, y: x // y)
        if b[0] <= 0 <= b[1]:
            quotients.append(0)
    else:
        quotients = [*_quotient(a, b, _toward_zero), 0]
    return (min(quotients), max(quotients))


def _remainder(op: Instr, a: Interval, b: Interval) -> Interval:
    """Smaller than the divisor, with the sign of the dividend (LLVM's) or of the divisor."""
    if op.mnemonic[0] == "u" and b[0] < 0:
        return full(op.type)
    if op.mnemonic[0] == "u":
        high = max(b[1] - 1, 0)
        return (0, min(high, a[1]) if a[0] >= 0 else high)
    if "floor" not in op.mnemonic:
        largest = max(abs(b[0]), abs(b[1]), 1) - 1
        return (max(-largest, min(a[0], 0)), min(largest, max(a[1], 0)))
    low, high = min(b[0] + 1, 0), max(b[1] - 1, 0)
    if a[0] >= 0 and b[0] >= 0:
        high = min(high, a[1])
    return (low, high)


def _abs(op: Instr, a: Interval, _: Interval) -> Interval:
    low = 0 if a[0] <= 0 <= a[1] else min(abs(a[0]), abs(a[1]))
    return (low, max(abs(a[0]), abs(a[1])))


_Rule = Callable[..., Interval]
_RULES: dict[str, _Rule] = {
    "add": lambda op, a, b: (a[0] + b[0], a[1] + b[1]),
    "sub": lambda op, a, b: (a[0] - b[1], a[1] - b[0]),
    "mul": _mul,
    "shl": _shl,
    "lshr": _lshr,
    "ashr": _ashr,
    "and": _and,
    "or": _bitwise,
    "xor": _bitwise,
    "udiv": _divide,
    "sdiv": _divide,
    "urem": _remainder,
    "srem": _remainder,
    "ufloordiv": _divide,
    "sfloordiv": _divide,
    "ufloorrem": _remainder,
    "sfloorrem": _remainder,
    "freeze": lambda op, a: a,
    "llvm.smin": lambda op, a, b: (min(a[0], b[0]), min(a[1], b[1])),
    "llvm.smax": lambda op, a, b: (max(a[0], b[0]), max(a[1], b[1])),
    "llvm.umin": _umin,
    "llvm.umax": _umax,
    "llvm.abs": _abs,
    "llvm.scmp": lambda op, a, b: (-1, 1),
    "llvm.ucmp": lambda op, a, b: (-1, 1),
    "llvm.ctpop": lambda op, a: (0, width(op.type)),
    "llvm.ctlz": lambda op, a, _: (0, width(op.type)),
    "llvm.cttz": lambda op, a, _: (0, width(op.type)),
}
_READ_AS_SIGNED = frozenset({"ashr", "sdiv", "srem", "llvm.smin", "llvm.smax", "llvm.abs"})
