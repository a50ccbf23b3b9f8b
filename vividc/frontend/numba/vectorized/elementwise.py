"""Functions made by `numba.vectorize`, in kernels: numba's array expressions call them for each
element, as what they were made of.

Numba would compile them for the host first, and link that. A function with fixed signatures
converts its arguments to the first of them that fits, as on the host.
"""

from __future__ import annotations

import functools
from typing import Any

import numba
from numba.core import types
from numba.core.typing import npydecl, signature
from numba.core.typing.templates import AbstractTemplate
from numba.np import numpy_support
from numba.np.ufunc.dufunc import DUFunc


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
