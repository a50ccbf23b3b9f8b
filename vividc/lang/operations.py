"""Operations of the array that Python has no words for (`vividc.lang`).

Each is a plain Python function on words, so a kernel that uses it also runs without numba. Numba
compiles it to one instruction for the host, and our target to one operation of the array.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from vividc.lang.formats import Narrow, fused
from vividc.lang.numba_types import overload_fused

MULHS = "vividc.mulhs"
MULHU = "vividc.mulhu"

_TARGET = "vividc"
_I32 = ir.IntType(32)
_I64 = ir.IntType(64)
_INTEGERS = (types.Integer, types.Boolean)


def fma(a: Any, b: Any, c: Any) -> Any:
    """a * b + c, rounded once.

    Parameters
    ----------
    a, b, c
        Numbers, each taken as float32; or three float16 or float8 numbers of one format, in which
        the result is rounded.
    """
    if isinstance(a, Narrow) or isinstance(b, Narrow) or isinstance(c, Narrow):
        return fused(a, b, c)
    x, y, z = (np.float32(value) for value in (a, b, c))
    if not all(np.isfinite(value) for value in (x, y, z)):
        with np.errstate(all="ignore"):
            return np.float32(np.float64(x) * np.float64(y) + np.float64(z))
    exact = Fraction(float(x)) * Fraction(float(y)) + Fraction(float(z))
    if exact == 0:
        return np.float32(np.float64(x) * np.float64(y) + np.float64(z))
    return _nearest(exact)


def _nearest(exact: Fraction) -> np.float32:
    """The float32 nearest to a number other than 0, ties to even."""
    _, exponent = np.frexp(float(exact)) if abs(exact) > Fraction(2) ** -1000 else (0, -200)
    unit = Fraction(2) ** max(int(exponent) - 24, -149)
    with np.errstate(over="ignore"):
        # At most 25 bits and a power of two: exact in float64.
        nearest = np.float32(float(round(exact / unit) * unit))
    return np.float32(np.copysign(nearest, 1 if exact > 0 else -1))


def mulhi(a: int, b: int) -> np.int32:
    """High word of the 64-bit product of two int32 values."""
    return np.int32((_signed(a) * _signed(b)) >> 32)


def mulhi_u(a: int, b: int) -> np.uint32:
    """High word of the 64-bit product of two uint32 values."""
    return np.uint32((_unsigned(a) * _unsigned(b)) >> 32)


def bitcast_f32(bits: int) -> np.float32:
    """The float32 that has the bits of a word."""
    (value,) = struct.unpack("<f", struct.pack("<I", _unsigned(bits)))
    return np.float32(value)


def bitcast_i32(value: float) -> np.int32:
    """The bits of a float32 as a word."""
    (bits,) = struct.unpack("<i", struct.pack("<f", np.float32(value)))
    return np.int32(bits)


def _unsigned(value: int) -> int:
    return int(value) & 0xFFFFFFFF


def _signed(value: int) -> int:
    return _unsigned(value) - ((_unsigned(value) & 0x80000000) << 1)


def _floats(context: Any, builder: ir.IRBuilder, signature: Any, args: Any) -> list[Any]:
    pairs = zip(args, signature.args, strict=True)
    return [context.cast(builder, value, type_, types.float32) for value, type_ in pairs]


def _words(context: Any, builder: ir.IRBuilder, signature: Any, args: Any) -> list[Any]:
    """The low words of integers."""
    words = []
    for value, type_ in zip(args, signature.args, strict=True):
        wide = context.cast(builder, value, type_, types.int64)
        words.append(builder.trunc(wide, _I32))
    return words


def _call(builder: ir.IRBuilder, symbol: str, type_: Any, args: list[Any]) -> Any:
    signature = ir.FunctionType(type_, [arg.type for arg in args])
    callee = cgutils.get_or_insert_function(builder.module, signature, symbol)
    callee.attributes.add("nounwind")
    callee.attributes.add("readnone")
    return builder.call(callee, args)


def _emit_fma(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    return builder.fma(*_floats(context, builder, signature, args))


def _emit_mulhi(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    words = _words(context, builder, signature, args)
    signed = signature.return_type == types.int32
    if context.codegen().magic_tuple() == (_TARGET,):
        return _call(builder, MULHS if signed else MULHU, _I32, words)
    widen = builder.sext if signed else builder.zext
    product = builder.mul(widen(words[0], _I64), widen(words[1], _I64))
    return builder.trunc(builder.lshr(product, _I64(32)), _I32)


def _emit_to_float(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    return builder.bitcast(_words(context, builder, signature, args)[0], ir.FloatType())


def _emit_to_word(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    return builder.bitcast(_floats(context, builder, signature, args)[0], _I32)


def _typed(emit: Callable[..., Any], result: Any, accepted: Any, args: Any) -> Any:
    """Result type and code generator of an intrinsic, if the arguments are what it takes."""
    if not all(isinstance(arg, accepted) for arg in args):
        return None
    return result(*args), emit


_Decorator = Callable[[Callable[..., Any]], Any]
_intrinsic: _Decorator = intrinsic
_overload: Callable[[Callable[..., Any]], _Decorator] = overload
_NUMBERS = (*_INTEGERS, types.Float)


@_intrinsic
def _fma(typingctx: Any, a: Any, b: Any, c: Any) -> Any:
    return _typed(_emit_fma, types.float32, _NUMBERS, (a, b, c))


@_intrinsic
def _mulhi(typingctx: Any, a: Any, b: Any) -> Any:
    return _typed(_emit_mulhi, types.int32, _INTEGERS, (a, b))


@_intrinsic
def _mulhi_u(typingctx: Any, a: Any, b: Any) -> Any:
    return _typed(_emit_mulhi, types.uint32, _INTEGERS, (a, b))


@_intrinsic
def _bitcast_f32(typingctx: Any, bits: Any) -> Any:
    return _typed(_emit_to_float, types.float32, _INTEGERS, (bits,))


@_intrinsic
def _bitcast_i32(typingctx: Any, value: Any) -> Any:
    return _typed(_emit_to_word, types.int32, _NUMBERS, (value,))


# Numba wants a Python function of the same signature, annotations included.
@_overload(fma)
def _overload_fma(a: Any, b: Any, c: Any) -> Any:
    narrow = overload_fused(a, b, c)
    if narrow is not None:
        return narrow

    def compute(a: Any, b: Any, c: Any) -> Any:
        return _fma(a, b, c)

    return compute


@_overload(mulhi)
def _overload_mulhi(a: Any, b: Any) -> Any:
    def compute(a: Any, b: Any) -> Any:
        return _mulhi(a, b)

    return compute


@_overload(mulhi_u)
def _overload_mulhi_u(a: Any, b: Any) -> Any:
    def compute(a: Any, b: Any) -> Any:
        return _mulhi_u(a, b)

    return compute


@_overload(bitcast_f32)
def _overload_bitcast_f32(bits: Any) -> Any:
    def compute(bits: Any) -> Any:
        return _bitcast_f32(bits)

    return compute


@_overload(bitcast_i32)
def _overload_bitcast_i32(value: Any) -> Any:
    def compute(value: Any) -> Any:
        return _bitcast_i32(value)

    return compute
