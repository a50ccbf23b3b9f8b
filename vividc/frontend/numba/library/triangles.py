"""`np.triu` and `np.tril` of matrices as one nest: numba makes them from a mask that it keeps.

On our target only; other dimensions are numba's own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]
_overload: Callable[..., _Decorator] = functools.partial(overload, target="vividc")
_MATRIX = 2


@_overload(np.triu)
def _overload_triu(m: Any, k: Any = 0) -> Any:
    return _upper if _is_matrix(m, k) else None


@_overload(np.tril)
def _overload_tril(m: Any, k: Any = 0) -> Any:
    return _lower if _is_matrix(m, k) else None


def _is_matrix(m: Any, k: Any) -> bool:
    """Whether these are a matrix and the number of a diagonal; numba refuses what is not one."""
    is_diagonal = isinstance(k, int | types.Integer | types.IntegerLiteral)
    return isinstance(m, types.Array) and m.ndim == _MATRIX and is_diagonal


def _upper(m: Any, k: Any = 0) -> Any:
    zero = m.dtype.type(0)
    out = np.empty(m.shape, m.dtype)
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            element = m[i, j]  # loaded in any case: a loop that branches is in no other's nest
            out[i, j] = element if j - i >= k else zero
    return out


def _lower(m: Any, k: Any = 0) -> Any:
    zero = m.dtype.type(0)
    out = np.empty(m.shape, m.dtype)
    for i in range(m.shape[0]):
        for j in range(m.shape[1]):
            element = m[i, j]
            out[i, j] = element if j - i <= k else zero
    return out
