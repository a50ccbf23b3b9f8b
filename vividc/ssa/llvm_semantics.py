"""What LLVM's operations compute, on integers with sign and floats, as far as kernels use them.

Where LLVM gives no meaning (a division by zero, a shift past the width) the result is some number,
as it is in words. Python's divisions, which round down, give 0 by zero.
"""

from __future__ import annotations

import math
import operator
import re
import struct
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Final

import numpy as np

from vividc.errors import SSAError
from vividc.ssa.ir import Instr, Kind

Number = int | float | np.floating
_TYPES: Final = re.compile(r"(\.[a-z]+\d+)+$")


def evaluate_llvm(instr: Instr, operands: list[Number]) -> Number:
    """The result of an operation that does not access memory.

    Parameters
    ----------
    operands
        Integers with sign, whatever their width, and floats.

    Raises
    ------
    SSAError
        There is no rule for the operation.
    """
    name = instr.mnemonic
    if name == "call":
        name = _TYPES.sub("", instr.pred.removeprefix("llvm."))
    if name in _SPECIAL:
        return _SPECIAL[name](instr, operands)
    if name in _CASTS:
        return _CASTS[name](instr, operands[0])
    if name in _FLOATS:
        return _rounded(_FLOATS[name], operands, instr.type)
    if name in _INTEGERS:
        whole = [wrapped(int(value), instr.type) for value in operands]
        return wrapped(_INTEGERS[name](int(str(instr.type)[1:]), *whole), instr.type)
    raise SSAError(f"there is no rule for {instr.mnemonic} {instr.pred}".rstrip())


def wrapped(value: int, kind: Kind) -> int:
    """The integer of a type with the low bits of `value`, with sign; predicates are 0 and 1."""
    bits = int(str(kind)[1:])
    low = value & (1 << bits) - 1
    return low - (1 << bits) if bits > 1 and low >> (bits - 1) else low


def _unsigned(value: int, bits: int) -> int:
    return value & (1 << bits) - 1


def _icmp(instr: Instr, operands: list[Number]) -> int:
    left, right = (wrapped(int(value), instr.type) for value in operands)
    if instr.pred[0] == "u":
        bits = int(str(instr.type)[1:])
        left, right = _unsigned(left, bits), _unsigned(right, bits)
    return int(_TESTS[instr.pred[-2:]](left, right))


def _fcmp(instr: Instr, operands: list[Number]) -> int:
    left, right = map(float, operands)
    unordered = math.isnan(left) or math.isnan(right)
    if instr.pred in ("ord", "uno"):
        return int(unordered == (instr.pred == "uno"))
    return int(instr.pred[0] == "u" if unordered else _TESTS[instr.pred[1:]](left, right))


def _select(instr: Instr, operands: list[Number]) -> Number:
    return operands[1] if int(operands[0]) & 1 else operands[2]


def _scmp(instr: Instr, operands: list[Number]) -> int:
    left, right = (int(value) for value in operands)
    return (left > right) - (left < right)


def _ucmp(instr: Instr, operands: list[Number]) -> int:
    """Sign extension keeps the unsigned order."""
    return _scmp(instr, [_unsigned(int(value), 64) for value in operands])


def _divided(a: int, b: int) -> int:
    return math.trunc(Fraction(a, b)) if b else 0


def _reversed(value: int, bits: int, unit: int) -> int:
    """The value with its groups of `unit` bits in the opposite order."""
    digits = f"{_unsigned(value, bits):0{bits}b}"
    return int("".join(digits[at : at + unit] for at in range(bits - unit, -1, -unit)), 2)


def _clamped(value: int, bits: int, *, signed: bool) -> int:
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    return max(low, min(high, value))


def _funnel(bits: int, high: int, low: int, by: int, *, left: bool) -> int:
    both = _unsigned(high, bits) << bits | _unsigned(low, bits)
    by %= bits
    return both << by >> bits if left else both >> by


def _rounded(rule: Callable[..., object], operands: list[Number], kind: Kind) -> Number:
    with np.errstate(all="ignore"):
        if kind == "float":
            return np.float32(rule(*(np.float64(value) for value in operands)))  # type: ignore[arg-type]
        return np.float64(rule(*(np.float64(value) for value in operands)))  # type: ignore[arg-type]


def _to_integer(instr: Instr, value: Number) -> int:
    if math.isnan(value):
        return 0
    bits, signed = int(str(instr.type)[1:]), instr.op == "fptosi"
    if math.isinf(value):
        return _clamped(int(math.copysign(2**64, value)), bits, signed=signed)
    return wrapped(_clamped(int(value), bits, signed=signed), instr.type)


def _to_float(instr: Instr, value: Number) -> Number:
    whole = int(value)
    if instr.op == "uitofp":
        whole = _unsigned(whole, int(instr.source[1:]))
    elif instr.source == "i1":
        whole = -whole
    return np.float32(whole) if instr.type == "float" else np.float64(whole)


def _extended(instr: Instr, value: Number) -> int:
    """zext, sext."""
    whole = wrapped(int(value), instr.source)
    if instr.op == "zext":
        whole = _unsigned(whole, int(instr.source[1:]))
    elif instr.source == "i1":
        whole = -whole
    return wrapped(whole, instr.type)


def _same_bits(instr: Instr, value: Number) -> Number:
    """bitcast."""
    if instr.type == instr.source:
        return value
    if instr.type == "float":
        return np.float32(struct.unpack("<f", struct.pack("<I", _unsigned(int(value), 32)))[0])
    return wrapped(struct.unpack("<I", struct.pack("<f", value))[0], instr.type)


_TESTS: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "eq": operator.eq,
    "ne": operator.ne,
    "lt": operator.lt,
    "le": operator.le,
    "gt": operator.gt,
    "ge": operator.ge,
}
_SPECIAL: Final[Mapping[str, Callable[[Instr, list[Number]], Number]]] = {
    "icmp": _icmp,
    "fcmp": _fcmp,
    "select": _select,
    "scmp": _scmp,
    "ucmp": _ucmp,
    "freeze": lambda instr, operands: operands[0],
}
_CASTS: Final[Mapping[str, Callable[[Instr, Number], Number]]] = {
    "trunc": lambda instr, value: wrapped(int(value), instr.type),
    "zext": _extended,
    "sext": _extended,
    "fptosi": _to_integer,
    "fptoui": _to_integer,
    "sitofp": _to_float,
    "uitofp": _to_float,
    "fptrunc": lambda instr, value: np.float32(value),
    "fpext": lambda instr, value: np.float64(value),
    "bitcast": _same_bits,
}


def _of_unsigned(rule: Callable[[int, int], int]) -> Callable[..., int]:
    return lambda bits, a, b: rule(_unsigned(a, bits), _unsigned(b, bits))


def _saturating(rule: Callable[[int, int], int], *, signed: bool) -> Callable[..., int]:
    if signed:
        return lambda bits, a, b: _clamped(rule(a, b), bits, signed=True)
    return lambda bits, a, b: _clamped(
        rule(_unsigned(a, bits), _unsigned(b, bits)), bits, signed=False
    )


_INTEGERS: Final[Mapping[str, Callable[..., int]]] = {
    "add": lambda bits, a, b: a + b,
    "sub": lambda bits, a, b: a - b,
    "mul": lambda bits, a, b: a * b,
    "and": lambda bits, a, b: a & b,
    "or": lambda bits, a, b: a | b,
    "xor": lambda bits, a, b: a ^ b,
    "shl": lambda bits, a, b: a << b % bits,
    "lshr": lambda bits, a, b: _unsigned(a, bits) >> b % bits,
    "ashr": lambda bits, a, b: a >> b % bits,
    "sdiv": lambda bits, a, b: _divided(a, b),
    "srem": lambda bits, a, b: a - b * _divided(a, b),
    "udiv": _of_unsigned(_divided),
    "urem": _of_unsigned(lambda a, b: a - b * _divided(a, b)),
    "sfloordiv": lambda bits, a, b: a // b if b else 0,
    "sfloorrem": lambda bits, a, b: a % b if b else 0,
    "ufloordiv": _of_unsigned(lambda a, b: a // b if b else 0),
    "ufloorrem": _of_unsigned(lambda a, b: a % b if b else 0),
    "smin": lambda bits, a, b: min(a, b),
    "smax": lambda bits, a, b: max(a, b),
    "umin": _of_unsigned(min),
    "umax": _of_unsigned(max),
    "abs": lambda bits, a, _: abs(a),
    "ctpop": lambda bits, a: _unsigned(a, bits).bit_count(),
    "ctlz": lambda bits, a, _: bits - _unsigned(a, bits).bit_length(),
    "cttz": lambda bits, a, _: (a & -a).bit_length() - 1 if a else bits,
    "bswap": lambda bits, a: _reversed(a, bits, 8),
    "bitreverse": lambda bits, a: _reversed(a, bits, 1),
    "fshl": lambda bits, a, b, by: _funnel(bits, a, b, by, left=True),
    "fshr": lambda bits, a, b, by: _funnel(bits, a, b, by, left=False),
    "sadd.sat": _saturating(operator.add, signed=True),
    "ssub.sat": _saturating(operator.sub, signed=True),
    "uadd.sat": _saturating(operator.add, signed=False),
    "usub.sat": _saturating(operator.sub, signed=False),
}
_UNARY: Final = ("exp", "exp2", "sqrt", "floor", "ceil", "trunc", "rint", "log", "log2", "log10")
_UNARY_TOO: Final = ("log1p", "expm1", "sin", "cos", "tan", "sinh", "cosh", "tanh")
_LIBRARY: Final[Mapping[str, Callable[..., object]]] = {
    **{name: getattr(np, name) for name in (*_UNARY, *_UNARY_TOO, "hypot", "fmod", "copysign")},
    **{name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan", "atan2")},
    "pow": np.power,
}
_FLOATS: Final[Mapping[str, Callable[..., object]]] = {
    "fadd": operator.add,
    "fsub": operator.sub,
    "fmul": operator.mul,
    "fdiv": np.divide,
    "frem": np.fmod,
    "fneg": operator.neg,
    "fabs": np.abs,
    **dict.fromkeys(("fma", "fmuladd"), lambda a, b, c: a * b + c),
    **dict.fromkeys(("minnum", "minimumnum"), np.fmin),
    **dict.fromkeys(("maxnum", "maximumnum"), np.fmax),
    **dict.fromkeys(("nearbyint", "roundeven"), np.rint),
    **_LIBRARY,
    **{f"{name}f": rule for name, rule in _LIBRARY.items()},  # C's functions of floats
}
