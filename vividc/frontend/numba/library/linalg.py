"""`np.dot`, `@`, `np.vdot`, `np.outer` and `np.cross` as loops: numba hands the former to BLAS,
which the array has not, and makes the latter from other arrays, whose sizes are known too late.

For the host our products stand in where numba's cannot work, without scipy.
"""

from __future__ import annotations

import functools
import importlib.util
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload, register_jitable
from numba.np.arraymath import check_axis_bounds
from numba.np.numpy_support import as_dtype

_TARGET = "vividc" if importlib.util.find_spec("scipy") is not None else "cpu"
_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]
overload_without_scipy: Callable[..., _Decorator] = functools.partial(overload, target=_TARGET)
_overload_here: Callable[..., _Decorator] = functools.partial(overload, target="vividc")
_helper: _Decorator = register_jitable
_SIZES = "incompatible array sizes for a product"


def _product(a: Any, b: Any) -> Callable[..., Any] | None:
    """The product of two arrays of floats or of complex numbers, which numba has of one type only;
    None: it is none.
    """
    if not isinstance(a, types.Array) or not isinstance(b, types.Array):
        return None
    kinds = {type(a.dtype), type(b.dtype)}
    if kinds not in ({types.Float}, {types.Complex}):
        return None
    return {(1, 1): _inner, (2, 1): _matrix_vector, (1, 2): _vector_matrix, (2, 2): _matrices}.get(
        (a.ndim, b.ndim)
    )


def _inner(a: Any, b: Any) -> Any:
    if a.shape[0] != b.shape[0]:
        raise ValueError(_SIZES)
    total = a.dtype.type(0)
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


def _matrix_vector(a: Any, b: Any) -> Any:
    if a.shape[1] != b.shape[0]:
        raise ValueError(_SIZES)
    out = np.empty(a.shape[0], a.dtype)
    for i in range(a.shape[0]):
        total = a.dtype.type(0)
        for k in range(a.shape[1]):
            total += a[i, k] * b[k]
        out[i] = total
    return out


def _vector_matrix(a: Any, b: Any) -> Any:
    if a.shape[0] != b.shape[0]:
        raise ValueError(_SIZES)
    out = np.empty(b.shape[1], a.dtype)
    for j in range(b.shape[1]):
        total = a.dtype.type(0)
        for k in range(a.shape[0]):
            total += a[k] * b[k, j]
        out[j] = total
    return out


def _matrices(a: Any, b: Any) -> Any:
    if a.shape[1] != b.shape[0]:
        raise ValueError(_SIZES)
    out = np.empty((a.shape[0], b.shape[1]), a.dtype)
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = a.dtype.type(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            out[i, j] = total
    return out


@overload_without_scipy(np.dot)
def _overload_dot(a: Any, b: Any) -> Any:
    return _product(a, b)


@overload_without_scipy(operator.matmul)
def _overload_matmul(a: Any, b: Any) -> Any:
    return _product(a, b)


@overload_without_scipy(np.vdot)
def _overload_vdot(a: Any, b: Any) -> Any:
    both = isinstance(a, types.Array) and isinstance(b, types.Array) and a.ndim == b.ndim == 1
    if both and isinstance(a.dtype, types.Complex):
        return _conjugate_inner if _product(a, b) is not None else None
    return _product(a, b) if both else None


def _conjugate_inner(a: Any, b: Any) -> Any:
    return np.dot(np.conj(a), b)


@overload_without_scipy(np.dot)
def _overload_dot_into(a: Any, b: Any, out: Any) -> Any:
    product = _product(a, b)
    if product is None or not isinstance(out, types.Array) or out.dtype != a.dtype:
        return None
    if product not in (_matrices, _matrix_vector, _vector_matrix):
        return None
    if product is _matrices:
        return _matrices_into
    return _matrix_vector_into if product is _matrix_vector else _vector_matrix_into


def _matrices_into(a: Any, b: Any, out: Any) -> Any:
    if a.shape[1] != b.shape[0] or out.shape != (a.shape[0], b.shape[1]):
        raise ValueError(_SIZES)
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = a.dtype.type(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            out[i, j] = total
    return out


def _matrix_vector_into(a: Any, b: Any, out: Any) -> Any:
    if a.shape[1] != b.shape[0] or out.shape[0] != a.shape[0]:
        raise ValueError(_SIZES)
    for i in range(a.shape[0]):
        total = a.dtype.type(0)
        for k in range(a.shape[1]):
            total += a[i, k] * b[k]
        out[i] = total
    return out


def _vector_matrix_into(a: Any, b: Any, out: Any) -> Any:
    if a.shape[0] != b.shape[0] or out.shape[0] != b.shape[1]:
        raise ValueError(_SIZES)
    for j in range(b.shape[1]):
        total = a.dtype.type(0)
        for k in range(a.shape[0]):
            total += a[k] * b[k, j]
        out[j] = total
    return out


@_overload_here(np.outer)
def _overload_outer(a: Any, b: Any) -> Any:
    """The products of two vectors, in numpy's type for them."""
    if not _are_vectors(a, b):
        return None
    kind = np.result_type(as_dtype(a.dtype), as_dtype(b.dtype)).type

    def outer(a: Any, b: Any) -> Any:
        return np.outer(a, b, np.empty((a.shape[0], b.shape[0]), kind))

    return outer


@_overload_here(np.outer)
def _overload_outer_into(a: Any, b: Any, out: Any) -> Any:
    if not _are_vectors(a, b) or not isinstance(out, types.Array) or out.ndim != 2:  # noqa: PLR2004
        return None

    def outer(a: Any, b: Any, out: Any) -> Any:
        if out.shape != (a.shape[0], b.shape[0]):
            raise ValueError(_SIZES)
        for i in range(a.shape[0]):
            for j in range(b.shape[0]):
                out[i, j] = a[i] * b[j]
        return out

    return outer


def _are_vectors(a: Any, b: Any) -> bool:
    return all(isinstance(x, types.Array) and x.ndim == 1 for x in (a, b))


@_overload_here(np.cross)
def _overload_cross(a: Any, b: Any) -> Any:
    """Of vectors and of matrices of them, row by row; None: of more dimensions."""
    kinds = [getattr(x, "dtype", None) for x in (a, b)]
    dims = [x.ndim if isinstance(x, types.Array) else 1 for x in (a, b)]
    if not all(isinstance(kind, types.Number) for kind in kinds) or max(dims) > _MATRIX:
        return None
    dtype = np.promote_types(*(as_dtype(kind) for kind in kinds))

    def of_vectors(a: Any, b: Any) -> Any:
        out = np.empty(3, dtype)
        _cross_into(np.asarray(a), np.asarray(b), out)
        return out

    def of_rows(a: Any, b: Any) -> Any:
        one, other = np.asarray(a), np.asarray(b)
        m, n = _rows_of(one), _rows_of(other)
        if m not in (n, 1) and n != 1:
            raise ValueError("unable to broadcast argument")
        out = np.empty((m if n == 1 else n, 3), dtype)
        for i in range(out.shape[0]):
            _cross_into(_row(one, i if m > 1 else 0), _row(other, i if n > 1 else 0), out[i])
        return out

    return of_vectors if max(dims) == 1 else of_rows


_MATRIX = 2


@_helper
def _cross_into(a: Any, b: Any, out: Any) -> None:
    """The product of two vectors; of one of two elements the third is 0."""
    if not (2 <= a.shape[0] <= 3 and 2 <= b.shape[0] <= 3):  # noqa: PLR2004
        raise ValueError("Incompatible dimensions for cross product (dimension must be 2 or 3)")
    if a.shape[0] == 2 and b.shape[0] == 2:  # noqa: PLR2004
        raise ValueError("Dimensions for both inputs is 2: use cross2d of numba.np.extensions")
    a2 = a[2] if a.shape[0] > 2 else a[0] * a.dtype.type(0)  # noqa: PLR2004
    b2 = b[2] if b.shape[0] > 2 else b[0] * b.dtype.type(0)  # noqa: PLR2004
    out[0] = a[1] * b2 - a2 * b[1]
    out[1] = a2 * b[0] - a[0] * b2
    out[2] = a[0] * b[1] - a[1] * b[0]


def _rows_of(x: Any) -> Any:
    """How many vectors a matrix, or a vector, has."""


@_overload_here(_rows_of)
def _overload_rows_of(x: Any) -> Any:
    def of_matrix(x: Any) -> Any:
        return x.shape[0]

    def of_vector(x: Any) -> Any:
        return 1

    return of_matrix if x.ndim == _MATRIX else of_vector


def _row(x: Any, i: Any) -> Any:
    """A vector of a matrix, or the vector itself."""


@_overload_here(_row)
def _overload_row(x: Any, i: Any) -> Any:
    def of_matrix(x: Any, i: Any) -> Any:
        return x[i]

    def of_vector(x: Any, i: Any) -> Any:
        return x

    return of_matrix if x.ndim == _MATRIX else of_vector


@_overload_here(check_axis_bounds)
def _overload_check(a: Any, axis: Any) -> Any:
    """Numba's check before a sum along an axis, but for its message, which it formats."""

    def check(a: Any, axis: Any) -> None:
        if axis < -a.ndim or axis >= a.ndim:
            raise ValueError("axis out of bounds")

    def nothing(a: Any, axis: Any) -> None:
        pass

    return check if isinstance(axis, types.Integer) else nothing
