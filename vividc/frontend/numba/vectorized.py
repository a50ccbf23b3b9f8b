"""Functions made by `numba.vectorize`, in kernels and as kernels: numba's array expressions call
them for each element, as what they were made of.

Numba would compile them for the host first, and link that. A function with fixed signatures
converts its arguments to the first of them that fits, as on the host.
"""

from __future__ import annotations

import ast
import functools
import inspect
from collections.abc import Callable, Container, Mapping, Sequence
from typing import Any

import numba
from numba.core import types
from numba.core.typing import npydecl, signature
from numba.core.typing.templates import AbstractTemplate
from numba.np import numpy_support
from numba.np.ufunc.dufunc import DUFunc
from numba.stencils.stencil import StencilFunc


@functools.lru_cache(maxsize=256)
def vectorized_type(function: DUFunc) -> types.Function:
    """Its type in calls on numbers and arrays; what is written to an `out` is not known."""

    def generic(self: Any, args: Any, kws: Any) -> Any:
        if kws or len(args) != function.nin or function.nout != 1:
            return None
        found = npydecl.Numpy_rules_ufunc._handle_inputs(function.ufunc, args, kws)
        of_elements, _, ndims, layout = found
        result = _of_elements(self.context, function, tuple(of_elements))
        if result is None:
            return None
        kind = result.return_type
        return signature(types.Array(kind, ndims, layout) if ndims else kind, *args)

    name = f"vectorized {function.__name__}"
    return types.Function(type(name, (AbstractTemplate,), {"key": function, "generic": generic}))


def _of_elements(typing: Any, function: DUFunc, kinds: tuple[Any, ...]) -> Any:
    """The signature for elements of these types; None: there is none."""
    if function._frozen:
        loop = numpy_support.ufunc_find_matching_loop(function, kinds)
        return None if loop is None else signature(loop.outputs[0], *loop.inputs)
    called = typing.resolve_value_type(_scalar_function(function))
    return called.get_call_type(typing, tuple(map(types.unliteral, kinds)), {})


@functools.lru_cache(maxsize=256)
def _scalar_function(function: DUFunc) -> Any:
    return numba.njit(function._dispatcher.py_func)


def call_on_numbers(context: Any, builder: Any, sig: Any, args: Any, function: DUFunc) -> Any:
    """What a call computes of numbers."""
    inner = _of_elements(context.typing_context, function, sig.args)
    given = [context.cast(builder, *one) for one in zip(args, sig.args, inner.args, strict=True)]
    made = context.compile_internal(builder, function._dispatcher.py_func, inner, given)
    return context.cast(builder, made, inner.return_type, sig.return_type)


def as_function(given: Any) -> Any:
    """What a kernel is made of: of a function of `numba.vectorize` or `numba.stencil` a call on
    whole arrays or numbers, of one that numba has compiled the function as written, anything else
    as it is.
    """
    if not isinstance(given, DUFunc | StencilFunc):
        return getattr(given, "py_func", given)
    return _calling(given)


@functools.lru_cache(maxsize=256)
def _calling(function: DUFunc | StencilFunc) -> Callable[..., Any]:
    is_stencil = isinstance(function, StencilFunc)
    written = function.kernel_ir.func_id.func if is_stencil else function._dispatcher.py_func
    names = tuple(inspect.signature(written).parameters)
    called = free_name("_vectorized", {*names, written.__name__})
    return function_like(written, names, f"{called}({', '.join(names)})", {called: function})


def function_like(
    written: Callable[..., Any], names: Sequence[str], value: str, known: Mapping[str, Any]
) -> Callable[..., Any]:
    """A function with the name, place and docstring of `written`, of parameters of these names,
    which returns the value of an expression of them and of what is `known`.
    """
    tree = ast.parse(f"def {written.__name__}({', '.join(names)}): return {value}")
    ast.increment_lineno(tree, written.__code__.co_firstlineno - 1)
    made: dict[str, Any] = {**known, "__name__": written.__module__}
    exec(compile(tree, written.__code__.co_filename, "exec"), made)
    found: Callable[..., Any] = made[written.__name__]
    found.__doc__ = written.__doc__
    return found


def free_name(name: str, taken: Container[str]) -> str:
    """A name that is none of `taken`."""
    while name in taken:
        name += "_"
    return name
