"""`np.cov` of a matrix as loops by hand: each sum of products once, and no copies between.

On our target only: numba's multiplies the matrix by all of its transpose, which it copies. Lists,
rows alone, two sets of variables and complex numbers are numba's own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload, register_jitable

from vividc.frontend.numba.library.sums import is_left_out

_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]
_overload: Callable[..., _Decorator] = functools.partial(overload, target="vividc")
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable
_MATRIX = 2


@_overload(np.cov)
def _overload_cov(
    m: Any, y: Any = None, rowvar: Any = True, bias: Any = False, ddof: Any = None
) -> Any:
    is_matrix = isinstance(m, types.Array) and m.ndim == _MATRIX
    if not (is_matrix and is_left_out(y) and isinstance(m.dtype, types.Float | types.Integer)):
        return None
    if not (is_left_out(ddof) or isinstance(ddof, types.Integer)):
        return None
    is_given = not is_left_out(ddof)
    kind = np.float32 if m.dtype == types.float32 else np.float64

    def cov(m: Any, y: Any = None, rowvar: Any = True, bias: Any = False, ddof: Any = None) -> Any:
        if m.shape[0] == 1:
            raise RuntimeError(
                "2D array containing a single row is unsupported due to ambiguity in type "
                "inference. To use numpy.cov in this case simply pass the row as a 1D array, "
                "i.e. m[0]."
            )
        less = 0 if bias else 1
        if is_given:
            less = ddof
        if rowvar:
            return _covariance(m, less, kind)
        return _covariance(m.T, less, kind)

    return cov


@_helper
def _covariance(m: Any, less: Any, kind: Any) -> Any:
    """Covariances of the rows of a matrix, of the sums of products over the columns but `less`."""
    rows, columns = m.shape
    out = np.empty((rows, rows), np.float64)
    mean = np.empty(rows, kind)
    apart = np.empty((rows, columns), kind)
    for i in range(rows):
        total = kind(0)
        for k in range(columns):
            total += m[i, k]
        mean[i] = np.true_divide(total, kind(columns))
    for i in range(rows):
        for k in range(columns):
            apart[i, k] = m[i, k] - mean[i]
    scale = np.nan if columns == 0 else np.true_divide(1, max(columns - less, 0.0))
    for i in range(rows):
        for j in range(i, rows):
            total = kind(0)
            for k in range(columns):
                total += apart[i, k] * apart[j, k]
            out[i, j] = total * scale
            out[j, i] = out[i, j]
    return out
