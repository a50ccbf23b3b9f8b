"""`np.sum` of a matrix of floats along an axis, a sum after the other in a register.

On our target only, for axes that are constants: numba's, which the method is, adds whole rows or
columns to an array of sums. The additions of a sum are the same, in the same order.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]
_overload: Callable[..., _Decorator] = functools.partial(
    overload, target="vividc", prefer_literal=True
)
_MATRIX = 2


@_overload(np.sum)
def _overload_sum(a: Any, axis: Any = None, dtype: Any = None) -> Any:
    is_matrix = isinstance(a, types.Array) and a.ndim == _MATRIX
    if not (is_matrix and isinstance(a.dtype, types.Float) and is_left_out(dtype)):
        return None
    return _ALONG.get(axis.literal_value) if isinstance(axis, types.IntegerLiteral) else None


def is_left_out(given: Any) -> bool:
    """Whether an argument is None, by a default or given so."""
    return given is None or isinstance(given, types.NoneType | types.Omitted)


def _of_columns(a: Any, axis: Any = None, dtype: Any = None) -> Any:
    sums = np.empty(a.shape[1], a.dtype)
    for j in range(a.shape[1]):
        total = a.dtype.type(0)
        for i in range(a.shape[0]):
            total += a[i, j]
        sums[j] = total
    return sums


def _of_rows(a: Any, axis: Any = None, dtype: Any = None) -> Any:
    sums = np.empty(a.shape[0], a.dtype)
    for i in range(a.shape[0]):
        total = a.dtype.type(0)
        for j in range(a.shape[1]):
            total += a[i, j]
        sums[i] = total
    return sums


_ALONG = {0: _of_columns, -2: _of_columns, 1: _of_rows, -1: _of_rows}
