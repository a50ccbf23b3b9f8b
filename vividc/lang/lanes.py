"""Words of two float16 or four float8 numbers: `vividc.lang.pack_fp8`, `dot_fp8` and their like.

In memory they are words; in the array each of these functions is one operation on lanes, or, for a
word of four numbers, two (`vividc.machine.lane_semantics`).
"""

# ruff: noqa: PLW0108 - numba compiles a function of its own where ours would be called.

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import intrinsic, overload

from vividc.formats import E4M3, E5M2, F16, Format, join, round_bits, split, to_float
from vividc.lang.numba_types import format_call, misuse
from vividc.machine.lane_semantics import LANE_SEMANTICS
from vividc.machine.opcodes import Opcode


def _packed(fmt: Format, *numbers: Any) -> np.uint32:
    return np.uint32(join(fmt, [round_bits(fmt, float(np.float32(x))) for x in numbers]))


def _dot(fmt: Format, x: Any, y: Any, total: Any) -> np.float32:
    result = np.float32(total)
    for a, b in zip(split(fmt, int(x)), split(fmt, int(y)), strict=True):
        with np.errstate(all="ignore"):
            result = np.float32(to_float(fmt, a) * to_float(fmt, b) + float(result))
    return result


def _larger(fmt: Format, x: int, y: int) -> np.uint32:
    return np.uint32(LANE_SEMANTICS[Opcode(f"fmax.{fmt.name}x{fmt.lanes}")](int(x), int(y)))


def pack_fp16(a: Any, b: Any) -> np.uint32:
    """Two numbers as float16 in a word, the first in its low bits."""
    return _packed(F16, a, b)


def pack_fp8(a: Any, b: Any, c: Any, d: Any) -> np.uint32:
    """Four numbers as float8 E4M3 in a word, the first in its lowest bits."""
    return _packed(E4M3, a, b, c, d)


def pack_e5m2(a: Any, b: Any, c: Any, d: Any) -> np.uint32:
    """Four numbers as float8 E5M2 in a word, the first in its lowest bits."""
    return _packed(E5M2, a, b, c, d)


def dot_fp16(x: int, y: int, total: Any) -> np.float32:
    """`total` plus the products of two words of float16, one after the other, in float32."""
    return _dot(F16, x, y, total)


def dot_fp8(x: int, y: int, total: Any) -> np.float32:
    """`total` plus the products of two words of float8 E4M3, one after the other, in float32."""
    return _dot(E4M3, x, y, total)


def dot_e5m2(x: int, y: int, total: Any) -> np.float32:
    """`total` plus the products of two words of float8 E5M2, one after the other, in float32."""
    return _dot(E5M2, x, y, total)


def max_fp16(x: int, y: int) -> np.uint32:
    """The larger number of two words of float16, lane by lane; a NaN loses, and -0 to +0."""
    return _larger(F16, x, y)


def max_fp8(x: int, y: int) -> np.uint32:
    """The larger number of two words of float8 E4M3, lane by lane; a NaN loses, and -0 to +0."""
    return _larger(E4M3, x, y)


def max_e5m2(x: int, y: int) -> np.uint32:
    """The larger number of two words of float8 E5M2, lane by lane; a NaN loses, and -0 to +0."""
    return _larger(E5M2, x, y)


_Intrinsic = Callable[[Callable[..., Any]], Any]
_intrinsic: _Intrinsic = intrinsic
_overload: Callable[..., _Intrinsic] = functools.partial(overload, strict=False)
_INTEGERS = (types.Integer, types.Boolean)
_NUMBERS = (*_INTEGERS, types.Float)


def _floats(context: Any, builder: Any, args: Any, kinds: Any) -> list[tuple[Any, Any]]:
    """Numbers as float32, with their type."""
    pairs = zip(args, kinds, strict=True)
    return [(context.cast(builder, x, kind, types.float32), types.float32) for x, kind in pairs]


def _words(context: Any, builder: Any, args: Any, kinds: Any) -> list[tuple[Any, Any]]:
    """Integers as words, with their type."""
    pairs = zip(args, kinds, strict=True)
    return [(context.cast(builder, x, kind, types.uint32), types.uint32) for x, kind in pairs]


def _emit_pack(fmt: Format, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    word = types.uint32
    numbers = _floats(context, builder, args, signature.args)
    low = format_call(context, builder, "pack", fmt, word, numbers[:2])
    if len(numbers) == 2:  # noqa: PLR2004 - the lanes that `pack` fills
        return low
    return format_call(context, builder, "pack_high", fmt, word, [*numbers[2:], (low, word)])


def _emit_dot(fmt: Format, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    kinds = signature.args
    words = _words(context, builder, args[:2], kinds[:2])
    total = _floats(context, builder, args[2:], kinds[2:])
    return format_call(context, builder, "dot", fmt, types.float32, [*words, *total])


def _emit_max(fmt: Format, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    word = types.uint32
    words = _words(context, builder, args, signature.args)
    return format_call(context, builder, "lanes_max", fmt, word, words)


def _check(name: str, accepted: Any, what: str, kinds: Any) -> None:
    for kind in kinds:
        if not isinstance(kind, accepted):
            raise misuse(f"lang.{name} of {types.unliteral(kind)}: it takes {what}")


def _register_pack(fmt: Format, function: Callable[..., Any]) -> None:
    what = "numbers, which it rounds; numbers of a format are cast with np.float32(...) before"
    if fmt.lanes == 2:  # noqa: PLR2004 - each count of lanes is a signature of its own

        @_intrinsic
        def pack_two(typingctx: Any, a: Any, b: Any) -> Any:
            return types.uint32(a, b), functools.partial(_emit_pack, fmt)

        @_overload(function)
        def overload_two(a: Any, b: Any) -> Any:
            _check(function.__name__, _NUMBERS, what, (a, b))
            return lambda a, b: pack_two(a, b)

        return

    @_intrinsic
    def pack_four(typingctx: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
        return types.uint32(a, b, c, d), functools.partial(_emit_pack, fmt)

    @_overload(function)
    def overload_four(a: Any, b: Any, c: Any, d: Any) -> Any:
        _check(function.__name__, _NUMBERS, what, (a, b, c, d))
        return lambda a, b, c, d: pack_four(a, b, c, d)


def _register_dot(fmt: Format, function: Callable[..., Any]) -> None:
    @_intrinsic
    def dot(typingctx: Any, x: Any, y: Any, total: Any) -> Any:
        return types.float32(x, y, total), functools.partial(_emit_dot, fmt)

    @_overload(function)
    def overload_dot(x: Any, y: Any, total: Any) -> Any:
        _check(function.__name__, _INTEGERS, "two words, as uint32, and a number", (x, y))
        _check(function.__name__, _NUMBERS, "two words, as uint32, and a number", (total,))
        return lambda x, y, total: dot(x, y, total)


def _register_max(fmt: Format, function: Callable[..., Any]) -> None:
    @_intrinsic
    def larger(typingctx: Any, x: Any, y: Any) -> Any:
        return types.uint32(x, y), functools.partial(_emit_max, fmt)

    @_overload(function)
    def overload_max(x: Any, y: Any) -> Any:
        _check(function.__name__, _INTEGERS, "two words, as uint32", (x, y))
        return lambda x, y: larger(x, y)


for _format, _pack, _sum, _max in (
    (F16, pack_fp16, dot_fp16, max_fp16),
    (E4M3, pack_fp8, dot_fp8, max_fp8),
    (E5M2, pack_e5m2, dot_e5m2, max_e5m2),
):
    _register_pack(_format, _pack)
    _register_dot(_format, _sum)
    _register_max(_format, _max)
