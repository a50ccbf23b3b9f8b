"""Loops over `range`, which compare with the stop value, where numba divides for a count;
and over `numba.prange`: where a kernel's source has them, and how their bounds reach LLVM.
"""

from __future__ import annotations

import ast
import dis
import inspect
import textwrap
from collections.abc import Callable, Iterator
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import RefType, iternext_impl

_I64 = ir.IntType(64)
_WORD_MAX = (1 << 31) - 1


def prange_lines(py_func: Callable[..., Any]) -> frozenset[int]:
    """Lines of the function's file in which a loop over `prange` begins."""
    names = inspect.getclosurevars(py_func)
    known = {**names.builtins, **names.globals, **names.nonlocals}
    try:
        lines, first = inspect.getsourcelines(py_func)
    except (OSError, TypeError):  # made by exec
        return frozenset(_lines_of_code(py_func, known))
    tree = ast.parse(textwrap.dedent("".join(lines)))
    return frozenset(first + node.lineno - 1 for node in _loops(tree) if _is_prange(node, known))


def calls_prange(py_func: Callable[..., Any]) -> str:
    """Name of a function that `py_func` calls, directly or not, with a loop over `prange`; "" if
    none has one.
    """
    seen = {py_func}
    pending = [py_func]
    while pending:
        names = inspect.getclosurevars(pending.pop())
        for value in (*names.globals.values(), *names.nonlocals.values()):
            called = getattr(value, "py_func", None)
            if inspect.isfunction(called) and called not in seen:
                if prange_lines(called):
                    return called.__name__
                seen.add(called)
                pending.append(called)
    return ""


def _lines_of_code(py_func: Callable[..., Any], known: dict[str, Any]) -> Iterator[int]:
    """Lines of the bytecode that name `prange`."""
    value: Any = None
    line = 0
    for instruction in dis.get_instructions(py_func):
        position = instruction.positions
        line = (position.lineno if position is not None else None) or line
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_DEREF"):
            value = known.get(instruction.argval)
        elif instruction.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            value = getattr(value, instruction.argval, None)
        else:
            continue
        if value is numba.prange:
            yield line


def _loops(tree: ast.AST) -> Iterator[ast.For]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.For))


def _is_prange(loop: ast.For, known: dict[str, Any]) -> bool:
    return isinstance(loop.iter, ast.Call) and _value(loop.iter.func, known) is numba.prange


def _value(expression: ast.expr, known: dict[str, Any]) -> Any:
    """What a name, or an attribute of one, means to the kernel."""
    if isinstance(expression, ast.Name):
        return known.get(expression.id)
    if isinstance(expression, ast.Attribute):
        return getattr(_value(expression.value, known), expression.attr, None)
    return None


def parallel_range(sig: Any, general: Any, builder: ir.IRBuilder, args: Any, *_: Any) -> Any:
    """Numba's lowering, `general`, of a range whose bounds are cut off where no loop gets to: a
    parallel loop counts in words.
    """
    pairs = zip(args, sig.args, strict=True)
    return general(builder, [_as_word(builder, arg, type_) for arg, type_ in pairs])


def _as_word(builder: ir.IRBuilder, value: Any, type_: Any) -> Any:
    """The nearest signed word of a signed integer of 64 bits."""
    if value.type != _I64 or not type_.signed:
        return value
    for limit, beyond in ((_WORD_MAX, ">"), (-_WORD_MAX - 1, "<")):
        is_beyond = builder.icmp_signed(beyond, value, _I64(limit))
        value = builder.select(is_beyond, _I64(limit), value)
    return value


_I64 = ir.IntType(64)
_RANGE = ir.LiteralStructType([_I64, _I64, _I64])


def _range_iterator(context: Any, sig: Any, builder: ir.IRBuilder, args: Any) -> Any:
    """Start, stop and step, widened, behind the first pointer of numba's iterator; its other fields
    stay unused.
    """
    dtype = sig.args[0].dtype
    slot = cgutils.alloca_once(builder, _RANGE)
    for position in range(3):
        word = builder.extract_value(args[0], position)
        if word.type.width < _I64.width:
            word = builder.sext(word, _I64) if dtype.signed else builder.zext(word, _I64)
        builder.store(word, cgutils.gep_inbounds(builder, slot, 0, position))
    step = builder.load(cgutils.gep_inbounds(builder, slot, 0, 2))
    with cgutils.if_unlikely(builder, builder.icmp_signed("==", step, _I64(0))):
        context.call_conv.return_user_exc(builder, ValueError, ("range() arg 3 must not be zero",))
    iterator = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    iterator.iter = builder.bitcast(slot, iterator.iter.type)
    return iterator._getvalue()


def _range_next(context: Any, sig: Any, builder: ir.IRBuilder, args: Any) -> Any:
    implementation = iternext_impl(RefType.UNTRACKED)(_range_step)
    return implementation(context, builder, sig, args)


def _range_step(context: Any, builder: ir.IRBuilder, sig: Any, args: Any, result: Any) -> None:
    slot = builder.bitcast(builder.extract_value(args[0], 0), _RANGE.as_pointer())
    field = [cgutils.gep_inbounds(builder, slot, 0, position) for position in range(3)]
    value, stop, step = (builder.load(pointer) for pointer in field)
    up = builder.icmp_signed("<", value, stop)
    down = builder.icmp_signed(">", value, stop)
    valid = builder.select(builder.icmp_signed(">", step, _I64(0)), up, down)
    result.set_valid(valid)
    item = context.get_value_type(sig.args[0].yield_type)
    result.yield_(value if item == _I64 else builder.trunc(value, item))
    # Unconditional, so that the loop keeps one plain induction: nobody looks at an exhausted
    # iterator.
    builder.store(builder.add(value, step, flags=["nsw"]), field[0])


RANGE_RULES: dict[tuple[str, type], Any] = {
    ("getiter", types.RangeType): _range_iterator,
    ("iternext", types.RangeIteratorType): _range_next,
}
"""What stands in for numba's lowering of loops over ranges, by its name of the step and type."""
