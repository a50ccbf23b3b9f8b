"""Functions that numba has made of a user's, as kernels: called on whole arrays or numbers."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

from numba.np.ufunc.dufunc import DUFunc
from numba.np.ufunc.gufunc import GUFunc
from numba.stencils.stencil import StencilFunc

from vividc.frontend.numba.vectorized.generalized import function_of_inputs
from vividc.frontend.numba.vectorized.written import free_name, function_like

_MADE = (DUFunc, GUFunc, StencilFunc)


def as_function(given: Any) -> Any:
    """What a kernel is made of: of a function of `numba.vectorize`, `numba.guvectorize` or
    `numba.stencil` a call on whole arrays or numbers, of one that numba has compiled the function
    as written, anything else as it is.
    """
    return _calling(given) if isinstance(given, _MADE) else getattr(given, "py_func", given)


@functools.lru_cache(maxsize=256)
def _calling(function: Any) -> Callable[..., Any]:
    written = _written(function)
    names = tuple(inspect.signature(written).parameters)
    called = free_name("_vectorized", {*names, written.__name__})
    heads, whole = names, function
    if isinstance(function, GUFunc):
        whole = function_of_inputs(function, written)
        heads = tuple(str(one) for one in inspect.signature(whole).parameters.values())
    return function_like(written, heads, f"{called}({', '.join(names)})", {called: whole})


def _written(function: Any) -> Callable[..., Any]:
    """The function that it was made of."""
    if isinstance(function, StencilFunc):
        found: Callable[..., Any] = function.kernel_ir.func_id.func
    elif isinstance(function, GUFunc):
        found = function.gufunc_builder.py_func
    else:
        found = function._dispatcher.py_func
    return found
