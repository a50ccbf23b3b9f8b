"""What a kernel raises: calls of functions named after it; and which divisions by zero do.

Numba's error model "numpy", the default here as on numba's GPUs, lets floats be infinite and
integers 0; "python" raises ZeroDivisionError. A function that a kernel calls has the kernel's model
unless it was given one itself, as in numba.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from string import printable
from typing import Any, Final
from urllib.parse import quote

import numba
from llvmlite import ir
from numba.core import callconv, cgutils, errors

from vividc.frontend.llvm.calls import RAISE_PREFIX, TRAP_PREFIX, USER_PREFIX

NUMPY: Final = "numpy"
ERROR_MODELS: Final = (NUMPY, "python")

_LIBRARIES: Final = (Path(numba.__file__).parent, Path(__file__).parents[2])
"""Where functions are whose raises are no user's."""

_PLAIN: Final = "".join(c for c in printable.strip() + " " if c not in '%"\\')

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


def _emit_call(builder: ir.IRBuilder, prefix: str, exc: Any, exc_args: Any) -> Any:
    """A call of what is named after the exception."""
    name = getattr(exc, "__name__", "exception")
    text = ", ".join(str(arg) for arg in exc_args or ())
    if prefix == USER_PREFIX:
        symbol = prefix + quote(f"{name}: {text}", _PLAIN, errors="backslashreplace")
    else:
        shown = "".join(c for c in f"{name}: {text}" if c.isascii() and c.isprintable())
        symbol = prefix + shown.replace('"', "'").replace("\\", "/")
    kind = ir.FunctionType(ir.VoidType(), ())
    callee = cgutils.get_or_insert_function(builder.module, kind, symbol)
    builder.call(callee, ())
    return callee


def _is_users(loc: Any) -> bool:
    """Whether a raise is a statement of a user's: builtins have no place, libraries have theirs."""
    return loc is not None and not any(map(Path(loc.filename).is_relative_to, _LIBRARIES))


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
            callee = _emit_call(builder, TRAP_PREFIX, exc, exc_args)
            callee.attributes.add("inaccessiblememonly")  # accesses move across it
            callee.attributes.add("nounwind")
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
        self._emit_raise(builder, exc, ("...",), loc)

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
