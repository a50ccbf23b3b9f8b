"""What a kernel raises: calls of functions named after it; and which divisions by zero do.

Numba's error model "numpy", the default here as on numba's GPUs, lets floats be infinite and
integers 0; "python" raises ZeroDivisionError. A function that a kernel calls has the kernel's model
unless it was given one itself, as in numba.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from string import printable
from typing import Any, Final
from urllib.parse import quote

import numba
from llvmlite import ir
from numba.core import callconv, cgutils, errors, types

from vividc.frontend.llvm.calls import RAISE_PREFIX, TRAP_PREFIX, USER_PREFIX
from vividc.frontend.numba.raises.texts import Text
from vividc.ssa.results import PLACE

NUMPY: Final = "numpy"
ERROR_MODELS: Final = (NUMPY, "python")

_LIBRARIES: Final = (Path(numba.__file__).parent, Path(__file__).parents[3])
"""Where functions are whose raises are no user's."""

_PLAIN: Final = "".join(c for c in printable.strip() + " " if c not in '%"\\')

_I64 = ir.IntType(64)
Said = tuple[str, Any]
"""A number that a text says: what it is, as of `ssa.results.Raise`, and its value."""

_model: ContextVar[str] = ContextVar("error_model", default=NUMPY)


@contextmanager
def of_model(model: str) -> Iterator[None]:
    """Compile for this error model."""
    before = _model.set(model)
    try:
        yield
    finally:
        _model.reset(before)


def model_of(host: Any) -> str:
    """The error model of a function that is called: its own, or the kernel's. None: the kernel."""
    options = getattr(host, "targetoptions", {})
    own = options.get("error_model") or getattr(host, "error_model", None)
    return own if own in ERROR_MODELS else _model.get()


def check_divisor(context: Any, builder: ir.IRBuilder, divisor: Any, text: str) -> None:
    """Raise ZeroDivisionError with this text of a divisor of 0, if the error model does."""
    if context.error_model.raise_on_fp_zero_division:
        with cgutils.if_zero(builder, divisor):
            context.error_model.fp_zero_division(builder, (text,), None)


def _emit_call(
    builder: ir.IRBuilder, prefix: str, exc: Any, exc_args: Any, numbers: Sequence[Said] = ()
) -> Any:
    """A call of what is named after the exception, with the numbers that its text says."""
    name = getattr(exc, "__name__", "exception")
    text = ", ".join(str(arg) for arg in exc_args or ())
    if prefix == USER_PREFIX:
        kinds = "".join(f"{PLACE}{kind}" for kind, _ in numbers)
        kinds = f"{kinds}{PLACE}" if kinds else ""
        symbol = prefix + quote(f"{kinds}{name}: {text}", _PLAIN, errors="backslashreplace")
    else:
        shown = "".join(c for c in f"{name}: {text}" if c.isascii() and c.isprintable())
        symbol = prefix + shown.replace('"', "'").replace("\\", "/")
    kind = ir.FunctionType(ir.VoidType(), [value.type for _, value in numbers])
    callee = cgutils.get_or_insert_function(builder.module, kind, symbol)
    builder.call(callee, [value for _, value in numbers])
    return callee


def trap(builder: ir.IRBuilder, exc: type[Exception], text: str) -> None:
    """Raise an exception behind which the kernel goes on: its loops keep one way out."""
    callee = _emit_call(builder, TRAP_PREFIX, exc, (text,))
    callee.attributes.add("inaccessiblememonly")  # accesses move across it
    callee.attributes.add("nounwind")


def _is_users(loc: Any) -> bool:
    """Whether a raise is a statement of a user's: builtins have no place, libraries have theirs."""
    return loc is not None and not any(map(Path(loc.filename).is_relative_to, _LIBRARIES))


def _number(builder: ir.IRBuilder, value: Any, kind: Any) -> Said | None:
    """A number to be said; None: it is none."""
    if isinstance(kind, types.Boolean):
        return "bool", builder.zext(builder.trunc(value, ir.IntType(1)), _I64)
    if isinstance(kind, types.Integer):
        if kind.bitwidth == _I64.width:
            return "int" if kind.signed else "uint", value
        return "int", (builder.sext if kind.signed else builder.zext)(value, _I64)
    if isinstance(kind, types.Float):
        single = ir.FloatType()
        return "float", value if value.type == single else builder.fptrunc(value, single)
    return None


class CallConv(callconv.MinimalCallConv):  # type: ignore[misc]
    """Status is the result: calls do not fail; a raise is a call of an undefined function, and so
    is what follows the check of a divisor, behind which the kernel goes on.
    """

    def _emit_raise(self, builder: ir.IRBuilder, exc: Any, exc_args: Any, loc: Any) -> None:
        _emit_call(builder, USER_PREFIX if _is_users(loc) else RAISE_PREFIX, exc, exc_args)
        builder.unreachable()

    def return_user_exc(
        self, builder: Any, exc: Any, exc_args: Any = None, loc: Any = None, func_name: Any = None
    ) -> None:
        if exc is ZeroDivisionError and func_name is None:  # numba's own check, of no user's raise
            trap(builder, exc, *exc_args)
        else:
            self._emit_raise(builder, exc, exc_args, loc)

    def return_dynamic_user_exc(
        self,
        builder: Any,
        exc: Any,
        exc_args: Any,
        nb_types: Any,
        loc: Any = None,
        func_name: Any = None,
    ) -> None:
        text = "..."
        numbers: list[Said] = []
        if isinstance(exc_args[0], Text):
            text, numbers = self._said(builder, exc_args, nb_types)
        _emit_call(builder, USER_PREFIX, exc, (text,), numbers)
        builder.unreachable()

    def _said(self, builder: ir.IRBuilder, exc_args: Any, nb_types: Any) -> tuple[str, list[Said]]:
        """A text with places, and the numbers that it says; what is none is said as numba does."""
        pieces = exc_args[0].split(PLACE)
        text = pieces[0]
        numbers: list[Said] = []
        for value, kind, piece in zip(exc_args[1:], nb_types[1:], pieces[1:], strict=True):
            number = _number(builder, value, kind)
            if number is None:
                literal = getattr(kind, "literal_value", f"<object type:{kind}>")
                text += f"{literal}{piece}"
            else:
                numbers.append(number)
                text += PLACE + piece
        return text, numbers

    def set_static_user_exc(self, *_: Any, **__: Any) -> None:
        """Numba asks for it to lower a raise inside `try`."""
        raise errors.UnsupportedError("`try` cannot run on the array")

    def check_try_status(self, *_: Any) -> None:
        """Numba asks for it to lower `try`."""
        raise errors.UnsupportedError("`try` cannot run on the array")

    set_try_status = unset_try_status = check_try_status

    def return_status_propagate(self, builder: Any, status: Any) -> None:
        builder.ret(status.code)

    def _get_return_status(self, builder: Any, code: Any) -> callconv.Status:
        none = builder.icmp_signed("==", code, callconv.RETCODE_NONE)
        true, false = cgutils.true_bit, cgutils.false_bit
        return callconv.Status(
            code=code,
            is_ok=true,
            is_none=none,
            is_error=false,
            is_stop_iteration=false,
            is_python_exc=false,
            is_user_exc=false,
            excinfoptr=None,
        )
