"""`np.linalg.cholesky`, `inv` and `solve` as loops: numba hands them to LAPACK, which the array has
not.

By Cholesky-Banachiewicz, and by Gauss-Jordan elimination with the largest pivot of a column (Golub
and Van Loan, "Matrix computations", 1996, 4.2 and 3.4): as exact as LAPACK's for matrices that are
small enough for a tile, and not bit for bit the same. For the host they stand in where numba's
cannot work, without scipy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import register_jitable
from numba.np.numpy_support import as_dtype

from vividc.frontend.numba.library.linalg import overload_without_scipy

_SQUARE = "Last 2 dimensions of the array must be square."
_SINGULAR = "Matrix is singular to machine precision."
_INDEFINITE = "Matrix is not positive definite."
_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


def _is_matrix(a: Any, kinds: Any = (types.Float, types.Complex)) -> bool:
    return isinstance(a, types.Array) and a.ndim == 2 and isinstance(a.dtype, kinds)  # noqa: PLR2004


@overload_without_scipy(np.linalg.cholesky)
def _overload_cholesky(a: Any) -> Any:
    return _cholesky if _is_matrix(a, types.Float) else None


def _cholesky(a: Any) -> Any:
    if a.shape[0] != a.shape[1]:
        raise np.linalg.LinAlgError(_SQUARE)
    out = np.tril(a)
    for i in range(a.shape[0]):
        for j in range(i):
            for k in range(j):
                out[i, j] -= out[i, k] * out[j, k]
            out[i, j] /= out[j, j]
        for k in range(i):
            out[i, i] -= out[i, k] * out[i, k]
        root = np.sqrt(out[i, i])
        out[i, i] = root if root > 0 else -1  # what is divided by is not 0
    for i in range(a.shape[0]):  # behind the nest, which has one exit so
        if not out[i, i] > 0:
            raise np.linalg.LinAlgError(_INDEFINITE)
    return out


@overload_without_scipy(np.linalg.inv)
def _overload_inv(a: Any) -> Any:
    return _inv if _is_matrix(a) else None


def _inv(a: Any) -> Any:
    if a.shape[0] != a.shape[1]:
        raise np.linalg.LinAlgError(_SQUARE)
    out = np.zeros(a.shape, a.dtype)
    for i in range(a.shape[0]):
        out[i, i] = 1
    _eliminate(a.copy(), out)
    return out


@overload_without_scipy(np.linalg.solve)
def _overload_solve(a: Any, b: Any) -> Any:
    if not _is_matrix(a) or not isinstance(b, types.Array):
        return None
    if b.dtype != a.dtype:
        return _solve_mixed(a, b)
    return {1: _solve_vector, 2: _solve}.get(b.ndim)


def _solve_mixed(a: Any, b: Any) -> Any:
    """As NumPy does: in the type that holds both."""
    if not isinstance(b.dtype, types.Float | types.Complex):
        return None
    both = np.promote_types(as_dtype(a.dtype), as_dtype(b.dtype)).type

    def solve(a: Any, b: Any) -> Any:
        return np.linalg.solve(a.astype(both), b.astype(both))

    return solve


def _solve(a: Any, b: Any) -> Any:
    if a.shape[0] != a.shape[1]:
        raise np.linalg.LinAlgError(_SQUARE)
    if a.shape[0] != b.shape[0]:
        raise np.linalg.LinAlgError("Incompatible array sizes, system is not dimensionally valid.")
    out = b.copy()
    _eliminate(a.copy(), out)
    return out


def _solve_vector(a: Any, b: Any) -> Any:
    column = np.empty((b.shape[0], 1), b.dtype)
    column[:, 0] = b
    return np.linalg.solve(a, column)[:, 0]


@_helper
def _eliminate(a: Any, b: Any) -> None:
    """Makes the solutions of `a @ x = b` of b; nothing useful is left in a."""
    for k in range(a.shape[0]):
        _exchange(a, b, k)
        scale = a.dtype.type(1) / a[k, k]
        for j in range(k, a.shape[1]):
            a[k, j] *= scale
        for j in range(b.shape[1]):
            b[k, j] *= scale
        for i in range(a.shape[0]):
            factor = a[i, k]
            if i != k:
                for j in range(k, a.shape[1]):
                    a[i, j] -= factor * a[k, j]
                for j in range(b.shape[1]):
                    b[i, j] -= factor * b[k, j]


@_helper
def _exchange(a: Any, b: Any, k: Any) -> None:
    """Brings the largest element of column k, from row k on, to row k."""
    row = k
    for i in range(k + 1, a.shape[0]):
        if abs(a[i, k]) > abs(a[row, k]):
            row = i
    if abs(a[row, k]) == 0:
        raise np.linalg.LinAlgError(_SINGULAR)
    for j in range(a.shape[1]):
        a[k, j], a[row, j] = a[row, j], a[k, j]
    for j in range(b.shape[1]):
        b[k, j], b[row, j] = b[row, j], b[k, j]
