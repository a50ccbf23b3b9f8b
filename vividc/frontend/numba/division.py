"""Python's `%`, `//` and `divmod` of floats, and `/` of complex numbers, as straight code: numba's
results without its branches, each of which would hold a remainder or a division of its own.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba.core import cgutils, types

from vividc.frontend.numba.raises.convention import check_divisor

Parts = Callable[[Any, ir.IRBuilder, Any, Any], Any]


def division(key: object, args: tuple[Any, ...]) -> Callable[..., Any] | None:
    """How to lower the operation `key` on arguments of these types; None: as numba does."""
    if key in (operator.truediv, operator.itruediv) and isinstance(args[0], types.Complex):
        return _complex_quotient
    parts = _DIVISIONS.get(key) if callable(key) else None
    if parts is None or len(args) != 2 or not all(isinstance(arg, types.Float) for arg in args):  # noqa: PLR2004
        return None

    def lower(context: Any, sig: Any, builder: ir.IRBuilder, values: Any, *_: Any) -> Any:
        operand = sig.args[0]
        x, y = (
            context.cast(builder, value, arg, operand)
            for value, arg in zip(values, sig.args, strict=True)
        )
        kind = "modulo" if parts is _modulo else "division"
        check_divisor(context, builder, y, f"{kind} by zero")
        return parts(context, builder, x, y)

    return lower


def _modulo(_: Any, builder: ir.IRBuilder, x: Any, y: Any) -> Any:
    """The remainder with the sign of y; so too if it is 0."""
    return _with_sign_of_divisor(builder, builder.frem(x, y), y)


def _floor_divide(_: Any, builder: ir.IRBuilder, x: Any, y: Any) -> Any:
    """The quotient less the remainder's share, rounded to an integer; x / y of y = 0."""
    return _floored(builder, x, y, builder.frem(x, y))


def _divmod(context: Any, builder: ir.IRBuilder, x: Any, y: Any) -> Any:
    rest = builder.frem(x, y)
    floored = _floored(builder, x, y, rest)
    return cgutils.pack_array(builder, (floored, _with_sign_of_divisor(builder, rest, y)))


def _differs(builder: ir.IRBuilder, rest: Any, y: Any) -> Any:
    """Whether the remainder is not 0 and of another sign than y."""
    zero = y.type(0.0)
    signs = builder.xor(builder.fcmp_ordered("<", y, zero), builder.fcmp_ordered("<", rest, zero))
    return builder.and_(signs, builder.fcmp_unordered("!=", rest, zero))


def _with_sign_of_divisor(builder: ir.IRBuilder, rest: Any, y: Any) -> Any:
    zero = y.type(0.0)
    moved = builder.select(_differs(builder, rest, y), builder.fadd(rest, y), rest)
    signed_zero = builder.select(builder.fcmp_ordered("<", y, zero), y.type(-0.0), zero)
    return builder.select(builder.fcmp_ordered("==", rest, zero), signed_zero, moved)


def _floored(builder: ir.IRBuilder, x: Any, y: Any, rest: Any) -> Any:
    zero, one = y.type(0.0), y.type(1.0)
    by_zero = builder.fcmp_ordered("==", y, zero)
    exact = builder.fsub(x, builder.select(by_zero, zero, rest))
    quotient = builder.fdiv(exact, y)
    less = builder.fsub(quotient, one)
    quotient = builder.select(_differs(builder, rest, y), less, quotient)
    floor = builder.module.declare_intrinsic("llvm.floor", [y.type])
    lower = builder.call(floor, (quotient,))
    far = builder.fcmp_ordered(">", builder.fsub(quotient, lower), y.type(0.5))
    snapped = builder.select(far, builder.fadd(lower, one), lower)
    binary = ir.FunctionType(y.type, (y.type, y.type))
    copysign = builder.module.declare_intrinsic("llvm.copysign", [y.type], binary)
    none = builder.call(copysign, (zero, x))
    none = builder.select(builder.fcmp_ordered("<", y, zero), builder.fneg(none), none)
    return builder.select(builder.fcmp_ordered("==", quotient, zero), none, snapped)


def _complex_quotient(context: Any, sig: Any, builder: ir.IRBuilder, args: Any, *_: Any) -> Any:
    """Smith's: dividend and divisor by the divisor's greater part first. As numba's it raises in
    either error model.
    """
    a, b = (
        context.make_complex(
            builder, sig.return_type, context.cast(builder, arg, kind, sig.return_type)
        )
        for arg, kind in zip(args, sig.args, strict=True)
    )
    zero = b.real.type(0.0)
    fabs = builder.module.declare_intrinsic("llvm.fabs", [b.real.type])
    sizes = [builder.call(fabs, (part,)) for part in (b.real, b.imag)]
    is_real = builder.fcmp_ordered(">=", *sizes)
    is_zero = builder.and_(is_real, builder.fcmp_ordered("==", sizes[0], zero))
    with cgutils.if_unlikely(builder, is_zero):
        context.call_conv.return_user_exc(builder, ZeroDivisionError, ("complex division by zero",))

    def ordered(one: Any, other: Any) -> tuple[Any, Any]:
        return builder.select(is_real, one, other), builder.select(is_real, other, one)

    greater, less = ordered(b.real, b.imag)
    ratio = builder.fdiv(less, greater)
    divisor = builder.fadd(greater, builder.fmul(less, ratio))
    first, second = ordered(a.real, a.imag)
    quotient = context.make_complex(builder, sig.return_type)
    real = builder.fadd(first, builder.fmul(second, ratio))
    imag = builder.fsub(*ordered(second, builder.fmul(first, ratio)))
    quotient.real, quotient.imag = builder.fdiv(real, divisor), builder.fdiv(imag, divisor)
    return quotient._getvalue()


_DIVISIONS: Final[dict[object, Parts]] = {
    operator.mod: _modulo,
    operator.imod: _modulo,
    operator.floordiv: _floor_divide,
    operator.ifloordiv: _floor_divide,
    divmod: _divmod,
}
