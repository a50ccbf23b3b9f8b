"""Sizes that are known when a kernel is compiled: shapes of arrays, values of integer scalars.

They become constants of the compilation, and a launch with others is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from vividc.errors import ArgumentError, demand_type, quoted
from vividc.machine.params import MAX_SPREAD, DType, Param

Like = Mapping[str, Any] | Sequence[Any]
"""What launches will be given, by name or for each parameter in order: arrays or whatever else has
a shape, shapes, and integers. None, floats and bools say nothing.
"""

_HINT: Final = "give one for each parameter, as in like=(A, B, n), or some by name: like={'n': 16}"


def with_sizes(name: str, params: tuple[Param, ...], like: Like) -> tuple[Param, ...]:
    """The parameters of kernel `name` with what is known of them; what was known before is not.

    Raises
    ------
    ArgumentError
        A name or a number of arguments that the kernel has not; a shape of another number of
        dimensions, another type, a size or value that no launch could have.
    """
    given = _by_name(name, params, like)
    return tuple(replace(p, known=_known(name, p, given.get(p.name))) for p in params)


def _by_name(name: str, params: tuple[Param, ...], like: Like) -> Mapping[str, Any]:
    demand_type(like, (Mapping, tuple, list), "like", _HINT)
    names = [param.name for param in params]
    if isinstance(like, Mapping):
        for key in like:
            if key not in names:
                reason = f"{name}({', '.join(names)}) has no parameter {quoted(key)}"
                raise ArgumentError(reason, hint=_HINT)
        return like
    if len(like) != len(names):
        reason = f"{name}({', '.join(names)}) takes {len(names)} arguments, not {len(like)}"
        raise ArgumentError(reason, hint=_HINT)
    return dict(zip(names, like, strict=True))


def _known(kernel: str, param: Param, value: Any) -> tuple[int, ...]:
    where = f"{param.name} of {kernel}"
    if value is None:
        return ()
    if param.ndim:
        return _shape(param, value, where)
    return _value(param, value, where)


def _shape(param: Param, value: Any, where: str) -> tuple[int, ...]:
    shape = getattr(value, "shape", value)
    if param.flat:
        if shape is value:
            hint = "C knows no shapes: give the scalars that say them"
            raise ArgumentError("the size of a pointer cannot be known", loc=where, hint=hint)
        return ()
    if _is_whole(shape):
        shape = (shape,)
    hint = "give an array, or its shape, as in (20, 30)"
    if not isinstance(shape, tuple | list) or not all(map(_is_whole, shape)):
        raise ArgumentError(f"a shape cannot be {quoted(shape)}", loc=where, hint=hint)
    dtype = getattr(value, "dtype", None)
    if dtype is not None and dtype != np.dtype(param.dtype.value):
        reason = f"expected {param.dtype.value}, got {quoted(str(dtype))[1:-1]}"
        raise ArgumentError(reason, loc=where)
    if len(shape) != param.ndim:
        reason = f"expected {param.ndim} dimension(s), got {len(shape)}"
        raise ArgumentError(reason, loc=where, hint=hint)
    for axis, size in enumerate(shape):
        most = MAX_SPREAD if axis == 0 else param.max_dimension
        if not 0 <= size <= most:
            raise ArgumentError(f"a dimension of {size} is not in 0 .. {most}", loc=where)
    return tuple(map(int, shape))


def _value(param: Param, value: Any, where: str) -> tuple[int, ...]:
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if param.dtype.is_float or param.dtype is DType.BOOL:
        if isinstance(value, int | float | complex | np.generic):
            return ()
        raise ArgumentError(f"expected {param.dtype.value}, got {quoted(value)}", loc=where)
    if not _is_whole(value):
        raise ArgumentError(f"expected {param.dtype.value}, got {quoted(value)}", loc=where)
    limits = np.iinfo(param.dtype.value)
    if not limits.min <= value <= limits.max:
        reason = f"{int(value)} does not fit {param.dtype.value}"
        raise ArgumentError(reason, loc=where)
    return (int(value),)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
