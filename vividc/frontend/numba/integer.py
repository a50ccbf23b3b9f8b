"""How numba's integer operators reach LLVM: division that rounds down as one call, powers as
multiplications.

Numba writes a floor division as a truncating one with a branch for zero and a correction, in which
neither LLVM nor we would find it again. Together with `target` and `subscripts` the only
module that relies on numba's internals.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import register_jitable

from vividc.frontend.llvm.calls import FLOOR_PREFIX
from vividc.frontend.numba.raises.convention import check_divisor

_POWERS = (pow, operator.pow, operator.ipow)
_DIVISIONS: dict[Any, tuple[str, ...]] = {
    operator.floordiv: ("div",),
    operator.ifloordiv: ("div",),
    operator.mod: ("rem",),
    operator.imod: ("rem",),
    divmod: ("div", "rem"),
}
_NAMES = {("div",): "division", ("rem",): "modulo", ("div", "rem"): "divmod"}
"""In what numba says of a divisor of zero."""
_POWER_BITS = 4
_LARGEST_COUNTED = 0x10000
_INTEGERS = "bBhHiIlLqQ"
"""NumPy's letters."""

Lowering = Callable[..., Any]
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


def integer_operator(context: Any, fn: Any, sig: Any, general: Lowering) -> Lowering:
    """Our lowering of an operator on integers; `general`, numba's, where we have none."""
    key = getattr(fn, "typing_key", fn)
    if key in _POWERS and _is_integer_power(sig.args):
        return functools.partial(_power, context, sig, general)
    if key in _DIVISIONS and all(isinstance(arg, types.Integer) for arg in sig.args):
        return functools.partial(_division, context, sig, _DIVISIONS[key])
    return general


def integer_loops(ufunc: Any) -> dict[str, Any]:
    """What stands in for numba's loops of a ufunc, by types ("ii->i"): powers of integers."""
    return {f"{i}{i}->{i}": _power_loop for i in _INTEGERS} if ufunc is np.power else {}


def _power_loop(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> Any:
    return _power(context, sig, None, builder, args)


def _is_integer_power(args: Any) -> bool:
    """Of a number: numba takes powers of arrays element by element, through this operator."""
    base, exponent = args
    return isinstance(base, types.Number) and isinstance(exponent, types.Integer)


def _division(
    context: Any, sig: Any, parts: tuple[str, ...], builder: ir.IRBuilder, args: Any, *_: Any
) -> Any:
    """Quotient, remainder or both, rounded down."""
    type_ = sig.return_type.dtype if len(parts) > 1 else sig.return_type
    operands = [
        context.cast(builder, arg, source, type_)
        for arg, source in zip(args, sig.args, strict=True)
    ]
    check_divisor(context, builder, operands[1], f"integer {_NAMES[parts]} by zero")
    sign = "s" if type_.signed else "u"
    values = [_call(builder, sign + part, operands) for part in parts]
    return values[0] if len(values) == 1 else cgutils.pack_array(builder, values)


def _call(builder: ir.IRBuilder, kind: str, operands: list[Any]) -> Any:
    type_ = operands[0].type
    wide = ir.IntType(64)
    extend = builder.sext if kind[0] == "s" else builder.zext
    if type_ != wide:
        operands = [extend(operand, wide) for operand in operands]
    signature = ir.FunctionType(wide, (wide, wide))
    callee = cgutils.get_or_insert_function(builder.module, signature, FLOOR_PREFIX + kind)
    callee.attributes.add("readnone")
    callee.attributes.add("nounwind")
    result = builder.call(callee, operands)
    return result if type_ == wide else builder.trunc(result, type_)


def _power(
    context: Any, sig: Any, general: Lowering | None, builder: ir.IRBuilder, args: Any, *_: Any
) -> Any:
    """Numba's multiplications in numba's order, but as straight code for exponents below 16.

    Numba runs a loop over the exponent's bits and trusts LLVM to unroll it. An integer's power
    has no other way than that loop here.
    """
    base = context.cast(builder, args[0], sig.args[0], sig.return_type)
    exponent = args[1]
    is_float = isinstance(sig.return_type, types.Float)
    multiply = builder.fmul if is_float else builder.mul
    slot = cgutils.alloca_once(builder, base.type)
    small = builder.icmp_unsigned("<", exponent, exponent.type(1 << _POWER_BITS))
    with builder.if_else(small) as (then, otherwise):
        with then:
            result = base.type(1)
            for bit in range(_POWER_BITS):
                chosen = builder.and_(exponent, exponent.type(1 << bit))
                is_set = builder.icmp_signed("!=", chosen, exponent.type(0))
                result = builder.select(is_set, multiply(result, base), result)
                base = multiply(base, base)
            builder.store(result, slot)
        with otherwise:
            if is_float and sig.args[1].signed:
                large = context.compile_internal(builder, _float_power(sig), sig, args)
            elif general is not None and is_float:
                large = general(builder, args)
            else:
                large = context.compile_internal(builder, _power_function(sig), sig, args)
            builder.store(large, slot)
    return builder.load(slot)


def _float_power(sig: Any) -> Callable[[Any, Any], Any]:
    """Numba's powers of a float to an integer, but for its exceptions: 0 to a negative power is an
    infinity.
    """
    type_ = sig.return_type

    def power(base: Any, exponent: Any) -> Any:
        result = type_(1)
        factor = type_(base)
        left = -exponent if exponent < 0 else exponent
        if left < 0 or left > _LARGEST_COUNTED:
            return math.pow(factor, type_(exponent))
        result = _times_power(result, factor, left)
        return np.divide(type_(1), result) if exponent < 0 else result

    return power


def _power_function(sig: Any) -> Callable[[int, int], int]:
    """Powers of integers, of which numba makes floats where the exponent is negative or large.

    A product that numba gets from `pow` does not fit 64 bits, so it has no meaning there; 0 to a
    negative power is the smallest integer, as in numba.
    """
    type_ = sig.return_type
    zero_inverse = type_(-1 << (type_.bitwidth - 1) if type_.signed else 0)

    def power(base: Any, exponent: Any) -> Any:
        result = type_(1)
        factor = type_(base)
        if exponent < 0:
            if factor == 0:
                return zero_inverse
            if factor == 1:
                return result
            return type_(1 - 2 * (exponent & 1)) if factor == -1 else type_(0)
        return _times_power(result, factor, exponent)

    return power


@_helper
def _times_power(result: Any, factor: Any, exponent: Any) -> Any:
    """`result` times a power of `factor` whose exponent is not negative."""
    while exponent != 0:
        if exponent & 1:
            result *= factor
        exponent >>= 1
        factor *= factor
    return result
