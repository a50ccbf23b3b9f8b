"""`np.where(condition, x, y)` on arrays as loops: numba makes it from lists of broadcast views.

On our target only. Dimensions of size 1 are broadcast as in numpy; arrays of fewer dimensions than
the condition are not, and end in numba's own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload, register_jitable
from numba.np.numpy_support import as_dtype

_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]
_overload: Callable[..., _Decorator] = functools.partial(overload, target="vividc")
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


def _extent(x: Any, dimension: int) -> Any:
    """The size of an operand along a dimension; a scalar's is 1."""
    return x.shape[dimension] if isinstance(x, np.ndarray) else 1


def _element(x: Any, index: Any) -> Any:
    """The element of an operand at an index of the result."""
    if not isinstance(x, np.ndarray):
        return x
    return x[tuple(0 if n == 1 else i for n, i in zip(x.shape, index, strict=True))]


@_overload(_extent)
def _overload_extent(x: Any, dimension: Any) -> Any:
    return _extent_of_array if isinstance(x, types.Array) else _extent_of_scalar


def _extent_of_array(x: Any, dimension: Any) -> Any:
    return x.shape[dimension]


def _extent_of_scalar(x: Any, dimension: Any) -> Any:
    return 1


@_overload(_element)
def _overload_element(x: Any, index: Any) -> Any:
    if not isinstance(x, types.Array):
        return _element_0
    return {1: _element_1, 2: _element_2, 3: _element_3}[x.ndim]


def _element_0(x: Any, index: Any) -> Any:
    return x


def _element_1(x: Any, index: Any) -> Any:
    return x[_along(x, index, 0)]


def _element_2(x: Any, index: Any) -> Any:
    return x[_along(x, index, 0), _along(x, index, 1)]


def _element_3(x: Any, index: Any) -> Any:
    return x[_along(x, index, 0), _along(x, index, 1), _along(x, index, 2)]


@_helper
def _along(x: Any, index: Any, dimension: Any) -> Any:
    return 0 if x.shape[dimension] == 1 else index[dimension]


@_helper
def _common(a: Any, b: Any) -> Any:
    if a not in (1, b) and b != 1:
        raise ValueError("unable to broadcast the operands of np.where")
    return b if a == 1 else a


@_helper
def _size(condition: Any, x: Any, y: Any, dimension: Any) -> Any:
    return _common(
        _common(_extent(condition, dimension), _extent(x, dimension)), _extent(y, dimension)
    )


@_overload(np.where)
def _overload_where(condition: Any, x: Any, y: Any) -> Any:
    if not isinstance(condition, types.Array) or condition.ndim not in _WHERE:
        return None
    for operand in (x, y):
        if isinstance(operand, types.Array):
            if operand.ndim != condition.ndim:
                return None
        elif not isinstance(operand, types.Number | types.Boolean):
            return None
    return _WHERE[condition.ndim](_type(x, y))


def _type(x: Any, y: Any) -> Any:
    """The result's: numpy's promotion of both."""
    kinds = [as_dtype(o.dtype if isinstance(o, types.Array) else o) for o in (x, y)]
    return np.promote_types(*kinds).type


def _where_1(kind: Any) -> Any:
    def where(condition: Any, x: Any, y: Any) -> Any:
        out = np.empty(_size(condition, x, y, 0), kind)
        for i in range(out.shape[0]):
            at = (i,)
            out[i] = _element(x, at) if _element(condition, at) else _element(y, at)
        return out

    return where


def _where_2(kind: Any) -> Any:
    def where(condition: Any, x: Any, y: Any) -> Any:
        out = np.empty((_size(condition, x, y, 0), _size(condition, x, y, 1)), kind)
        for i in range(out.shape[0]):
            for j in range(out.shape[1]):
                at = (i, j)
                out[at] = _element(x, at) if _element(condition, at) else _element(y, at)
        return out

    return where


def _where_3(kind: Any) -> Any:
    def where(condition: Any, x: Any, y: Any) -> Any:
        rows, columns = _size(condition, x, y, 1), _size(condition, x, y, 2)
        out = np.empty((_size(condition, x, y, 0), rows, columns), kind)
        for i in range(out.shape[0]):
            for j in range(rows):
                for k in range(columns):
                    at = (i, j, k)
                    out[at] = _element(x, at) if _element(condition, at) else _element(y, at)
        return out

    return where


_WHERE = {1: _where_1, 2: _where_2, 3: _where_3}
