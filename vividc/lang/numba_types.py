"""float16 and float8 as numba types: casts, arithmetic and comparisons.

A number is a word that holds its code. On our target each operation is a call of a function named
after it (`symbol`), which becomes one operation of the array; on the host it is computed in
binary64 and rounded once (`host`).
"""

# ruff: noqa: PLW0108 - numba compiles a function of its own where ours would be called.

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from llvmlite import ir
from numba.core import cgutils, errors, types
from numba.core.datamodel import register_default
from numba.core.datamodel.models import DataModel
from numba.core.typing.typeof import typeof_impl
from numba.extending import intrinsic, lower_builtin, lower_cast, overload

from vividc.formats import E4M3, E5M2, F16, FORMATS, Format
from vividc.lang import formats as lang_formats
from vividc.lang.formats import CASTS, MISUSE, NAMES, mixed
from vividc.lang.host import HOST
from vividc.lang.numba_words import plain

_TARGET = "vividc"
_I32 = ir.IntType(32)
_PREFIX = "vividc.format."


class FormatType(types.Number):  # type: ignore[misc]
    """Numba's type of the numbers of a format."""

    def __init__(self, fmt: Format) -> None:
        self.format = fmt
        super().__init__(name=f"lang.{CASTS[fmt]}")

    def unify(self, typingctx: Any, other: Any) -> Any:
        """A variable holds numbers of one format: nothing is converted without a cast."""
        return self if self == other else None


TYPES: Final = {fmt: FormatType(fmt) for fmt in FORMATS.values()}
"""Numba type of each format."""


def symbol(operation: str, fmt: Format) -> str:
    """Name of the function that our target calls for an operation of a format."""
    return f"{_PREFIX}{operation}.{fmt.name}"


@register_default(FormatType)
class _Model(DataModel):  # type: ignore[misc]
    """A word in registers; in memory as many bytes as the format has."""

    def get_value_type(self) -> Any:
        return _I32

    def get_data_type(self) -> Any:
        return ir.IntType(self._fe_type.format.bits)

    def as_data(self, builder: Any, value: Any) -> Any:
        return builder.trunc(value, self.get_data_type())

    def from_data(self, builder: Any, value: Any) -> Any:
        return builder.zext(value, _I32)

    def as_argument(self, builder: Any, value: Any) -> Any:
        return value

    def from_argument(self, builder: Any, value: Any) -> Any:
        return value

    def as_return(self, builder: Any, value: Any) -> Any:
        return value

    def from_return(self, builder: Any, value: Any) -> Any:
        return value


_typeof: Callable[[type], Callable[[Callable[..., Any]], Any]] = typeof_impl.register
_cast_rule: Callable[..., Callable[[Callable[..., Any]], Any]] = lower_cast


class HalfArray(np.ndarray[Any, Any]):
    """A float16 array as numba sees it, whose own type of that name has no operations."""


@_typeof(HalfArray)
def _typeof_half(value: Any, _: Any) -> Any:
    readonly = not value.flags.writeable
    layout = "C" if value.flags.c_contiguous else "A"
    return types.Array(TYPES[F16], value.ndim, layout, readonly=readonly)


def in_arrays(type_: Any) -> Any:
    """A parameter's type with float16 elements as numbers of ours."""
    if isinstance(type_, types.Array) and type_.dtype == types.float16:
        return type_.copy(dtype=TYPES[F16])
    return type_


def for_numba(value: Any) -> Any:
    """An argument as numba is to see it: float16 arrays as `HalfArray`, in the same memory."""
    if isinstance(value, np.ndarray) and value.dtype == np.float16:
        return value.view(HalfArray)
    return value


def format_call(
    context: Any, builder: Any, operation: str, fmt: Format, result: Any, args: Any
) -> Any:
    """Call of the array's operation, or its code for the host.

    `result`: its numba type, uint32 for a code. `args`: values, with their numba types.
    """
    values = [value for value, _ in args]
    kinds = [types.uint32 if isinstance(kind, FormatType) else kind for _, kind in args]
    if context.codegen().magic_tuple() != (_TARGET,):
        host = HOST[fmt][operation]
        return context.compile_internal(builder, host, result(*kinds), values)
    returned = context.get_value_type(result)
    signature = ir.FunctionType(returned, [value.type for value in values])
    callee = cgutils.get_or_insert_function(builder.module, signature, symbol(operation, fmt))
    callee.attributes.add("nounwind")
    callee.attributes.add("readnone")
    return builder.call(callee, values)


def _as_float(context: Any, builder: Any, value: Any, kind: Any) -> Any:
    """Any number as float32."""
    if isinstance(kind, FormatType):
        return format_call(context, builder, "to_f32", kind.format, types.float32, [(value, kind)])
    return context.cast(builder, value, kind, types.float32)


def _from_number(fmt: Format, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    (value,), (kind,) = args, signature.args
    if kind == TYPES[fmt]:
        return value
    number = _as_float(context, builder, value, kind)
    word = types.uint32
    return format_call(context, builder, "from_f32", fmt, word, [(number, types.float32)])


def _from_code(fmt: Format, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    wide = context.cast(builder, args[0], signature.args[0], types.uint32)
    return builder.and_(wide, _I32(fmt.mask))


def _arithmetic(operation: str, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    fmt = signature.return_type.format
    pairs = list(zip(args, signature.args, strict=True))
    return format_call(context, builder, operation, fmt, types.uint32, pairs)


def _sign(operation: str, _: Any, builder: Any, signature: Any, args: Any) -> Any:
    fmt = signature.return_type.format
    if operation == "neg":
        return builder.xor(args[0], _I32(fmt.sign))
    return builder.and_(args[0], _I32(fmt.sign - 1))


def _comparison(operation: str, context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """By the exact values as float32."""
    left, right = (
        _as_float(context, builder, value, kind)
        for value, kind in zip(args, signature.args, strict=True)
    )
    order = builder.fcmp_unordered if operation == "!=" else builder.fcmp_ordered
    return order(operation, left, right)


_Intrinsic = Callable[[Callable[..., Any]], Any]
_intrinsic: _Intrinsic = intrinsic
_overload: Callable[..., _Intrinsic] = functools.partial(overload, strict=False)
_NUMBERS = (types.Integer, types.Boolean, types.Float, FormatType)
_INTEGERS = (types.Integer, types.Boolean)


@_cast_rule(FormatType, types.Float)
def _to_float(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    number = _as_float(context, builder, value, given)
    return context.cast(builder, number, types.float32, wanted)


@_cast_rule(FormatType, types.Integer)
def _to_integer(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    number = _as_float(context, builder, value, given)
    return context.cast(builder, number, types.float32, wanted)


@_cast_rule(FormatType, types.Boolean)
def _to_boolean(context: Any, builder: Any, given: Any, _: Any, value: Any) -> Any:
    number = _as_float(context, builder, value, given)
    return builder.fcmp_unordered("!=", number, ir.FloatType()(0.0))


def _truth(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Of `if x:`, whose condition numba makes a bool without a cast."""
    return _to_boolean(context, builder, signature.args[0], types.boolean, args[0])


lower_builtin(bool, FormatType)(_truth)


def misuse(text: str) -> Exception:
    error: Exception = errors.NumbaValueError(MISUSE + text)
    return error


def _name(kind: Any) -> str:
    if isinstance(kind, FormatType):
        return NAMES[kind.format]
    return plain(str(types.unliteral(kind)))


def _register_cast(fmt: Format) -> None:
    """`lang.fp16(x)` and its like."""
    cast = CASTS[fmt]

    @_intrinsic
    def from_number(typingctx: Any, x: Any) -> Any:
        return TYPES[fmt](x), functools.partial(_from_number, fmt)

    @_intrinsic
    def from_code(typingctx: Any, bits: Any) -> Any:
        return TYPES[fmt](bits), functools.partial(_from_code, fmt)

    @_overload(lang_formats.FROM_NUMBER[fmt])
    def overload_cast(value: Any) -> Any:
        if isinstance(value, types.Array):
            what = f"lang.{cast} of an array of {_name(value.dtype)}"
            raise misuse(f"{what}: it takes one number, so cast the elements in a loop")
        if not isinstance(value, _NUMBERS):
            raise misuse(f"lang.{cast} of {_name(value)}: it takes a number")
        return lambda value: from_number(value)

    @_overload(lang_formats.FROM_BITS[fmt])
    def overload_from_code(bits: Any) -> Any:
        if not isinstance(bits, _INTEGERS):
            raise misuse(f"lang.{cast}_from_bits of {_name(bits)}: it takes an integer")
        return lambda bits: from_code(bits)


for _format in (F16, E4M3, E5M2):
    _register_cast(_format)


@_intrinsic
def _code(typingctx: Any, value: Any) -> Any:
    return types.uint32(value), lambda context, builder, signature, args: args[0]


@_overload(lang_formats.bits_of)
def _overload_bits_of(value: Any) -> Any:
    if not isinstance(value, FormatType):
        raise misuse(f"lang.bits_of of {_name(value)}: it takes a float16 or float8 number")
    return lambda value: _code(value)


@_intrinsic
def _fused(typingctx: Any, a: Any, b: Any, c: Any) -> Any:
    return a(a, b, c), functools.partial(_arithmetic, "fma")


def overload_fused(a: Any, b: Any, c: Any) -> Any:
    """What `lang.fma` does with numbers of a format; None if none of the three is one."""
    formats = [kind for kind in (a, b, c) if isinstance(kind, FormatType)]
    if not formats:
        return None
    for kind in (a, b, c):
        if kind != formats[0]:
            raise misuse(mixed(_name(formats[0]), _name(kind), CASTS[formats[0].format]))

    def compute(a: Any, b: Any, c: Any) -> Any:
        return _fused(a, b, c)

    return compute


def _checked_pair(left: Any, right: Any) -> bool:
    """Whether an operator is ours; a pair of two formats, or of one and a number, is refused."""
    ours = [kind for kind in (left, right) if isinstance(kind, FormatType)]
    if not ours or left == right:
        return bool(ours)
    raise misuse(mixed(_name(left), _name(right), CASTS[ours[0].format]))


def _register_binary(key: Any, operation: str) -> None:
    @_intrinsic
    def compute(typingctx: Any, left: Any, right: Any) -> Any:
        return left(left, right), functools.partial(_arithmetic, operation)

    @_overload(key)
    def overload_binary(left: Any, right: Any) -> Any:
        if not _checked_pair(left, right):
            return None
        return lambda left, right: compute(left, right)


def _register_comparison(key: Any, operation: str) -> None:
    @_intrinsic
    def compute(typingctx: Any, left: Any, right: Any) -> Any:
        return types.boolean(left, right), functools.partial(_comparison, operation)

    @_overload(key)
    def overload_comparison(left: Any, right: Any) -> Any:
        if not _checked_pair(left, right):
            return None
        return lambda left, right: compute(left, right)

    # For numba's min and max, which ask for the comparison without typing a call of it.
    lower_builtin(key, FormatType, FormatType)(functools.partial(_comparison, operation))


def _register_sign(key: Any, operation: str) -> None:
    @_intrinsic
    def compute(typingctx: Any, value: Any) -> Any:
        return value(value), functools.partial(_sign, operation)

    @_overload(key)
    def overload_sign(value: Any) -> Any:
        return (lambda value: compute(value)) if isinstance(value, FormatType) else None


for _key, _operation in (
    (operator.add, "add"),
    (operator.iadd, "add"),
    (operator.sub, "sub"),
    (operator.isub, "sub"),
    (operator.mul, "mul"),
    (operator.imul, "mul"),
):
    _register_binary(_key, _operation)
for _key, _operation in (
    (operator.eq, "=="),
    (operator.ne, "!="),
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
):
    _register_comparison(_key, _operation)
_register_sign(operator.neg, "neg")
_register_sign(abs, "abs")


@_overload(operator.not_)
def _overload_not(value: Any) -> Any:
    return (lambda value: not bool(value)) if isinstance(value, FormatType) else None


@_overload(operator.pos)
def _overload_pos(value: Any) -> Any:
    return (lambda value: value) if isinstance(value, FormatType) else None


def _refuse(key: Any, what: str) -> None:
    @_overload(key)
    def overload_refused(left: Any, right: Any) -> Any:
        if not any(isinstance(kind, FormatType) for kind in (left, right)):
            return None
        names = f"{_name(left)} and {_name(right)}"
        raise misuse(f"{what} of {names}: the array divides float32, so cast with np.float32(...)")


for _key, _what in (
    (operator.truediv, "`/`"),
    (operator.itruediv, "`/`"),
    (operator.floordiv, "`//`"),
    (operator.mod, "`%`"),
    (operator.pow, "`**`"),
):
    _refuse(_key, _what)


@_overload(float)
def _overload_float(value: Any) -> Any:
    return (lambda value: np.float32(value)) if isinstance(value, FormatType) else None


def _refuse_function(key: Any) -> None:
    @_overload(key)
    def overload_function(x: Any) -> Any:
        if not isinstance(x, FormatType):
            return None
        cast = CASTS[x.format]
        instead = f"write lang.{cast}(math.{key.__name__}(np.float32(x)))"
        raise misuse(f"math.{key.__name__} of {_name(x)}: {instead}")


for _function in (math.exp, math.sqrt, math.log, math.sin, math.cos, math.floor, math.tanh):
    _refuse_function(_function)
