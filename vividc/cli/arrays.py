"""Kernel arguments in `.npz` files, by parameter name."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vividc.errors import ArgumentError, quoted
from vividc.host.files import write_whole
from vividc.host.inputs import ARGUMENT_BYTES
from vividc.host.npz import Header, opened_npz
from vividc.machine.params import DType, Param
from vividc.ssa.results import named_leaves

Array = NDArray[Any]
RETURN_KEY = "return"

_HINT: Final = "write it with numpy.savez(path, x=x, ...)"


def read_arguments(path: Path, params: Sequence[Param]) -> dict[str, Array]:
    """The arguments of a launch, in the order of `params`; scalars are 0-d arrays.

    Raises
    ------
    ArgumentError
        Not an `.npz` file, or names, types or dimensions that do not fit; says what is expected.
    """
    with opened_npz(path, ARGUMENT_BYTES, ArgumentError, _HINT) as npz:
        _demand(path, params, _problems(npz.headers, params))  # before any data is unpacked
        arrays = npz.arrays()
    _demand(path, params, _wrong_scalars(arrays, params))
    arrays |= {
        p.name: np.asarray(p.default[0]) for p in params if p.default and p.name not in arrays
    }
    return {param.name: _in_c_order(arrays[param.name]) for param in params}


def write_results(path: Path, arguments: Mapping[str, Array], value: object) -> None:
    """Write the arrays after the run, and what was returned as `return`, the parts of a tuple as
    `return0`, `return1`, and so on.
    """
    arrays = {name: array for name, array in arguments.items() if array.ndim > 0}
    arrays |= named_leaves(value, RETURN_KEY)
    write_whole(path, _npz(arrays))


def describe(param: Param) -> str:
    """A parameter as a person writes it, such as `x: float32[:,:]`."""
    axes = "..." if param.flat else ",".join(":" * param.ndim)
    return f"{param.name}: {param.dtype.value}" + (f"[{axes}]" if param.ndim else "")


def _demand(path: Path, params: Sequence[Param], problems: Sequence[str]) -> None:
    if problems:
        expected = ", ".join(describe(param) for param in params)
        hint = f"expected: {expected or 'no arguments'}"
        raise ArgumentError("; ".join(problems), loc=str(path), hint=hint)


def _npz(arrays: Mapping[str, Array]) -> bytes:
    """As `numpy.savez`, which cannot name an array `file` and stamps the time of day."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    return data.getvalue()


def _problems(headers: Mapping[str, Header], params: Sequence[Param]) -> list[str]:
    known = {param.name for param in params}
    missing = [p.name for p in params if p.name not in headers and not p.default]
    problems = [f"`{name}` is missing" for name in missing]
    problems += [
        f"`{quoted(name)[1:-1]}` is not a parameter" for name in headers if name not in known
    ]
    for param in params:
        if param.name in headers:
            problems += _misfit(headers[param.name], param)
    return problems


def _misfit(array: Header, param: Param) -> list[str]:
    given = f"{array.dtype}[{','.join(map(str, array.shape))}]" if array.ndim else str(array.dtype)
    axes_fit = array.ndim == param.ndim or (param.flat and array.ndim > 0)
    if not axes_fit or (param.ndim and array.dtype != np.dtype(param.dtype.value)):
        return [f"`{param.name}` is {given}, not {describe(param).partition(': ')[2]}"]
    return []


def _wrong_scalars(arrays: Mapping[str, Array], params: Sequence[Param]) -> list[str]:
    scalars = [(p, arrays[p.name]) for p in params if not p.ndim and p.name in arrays]
    return [
        f"`{param.name}` = {quoted(array[()])} is not a {param.dtype.value}"
        for param, array in scalars
        if not _scalar_fits(array, param.dtype)
    ]


def _scalar_fits(array: Array, dtype: DType) -> bool:
    """A scalar may be of another type than its parameter as long as its value is representable."""
    if dtype is DType.C64:
        return array.dtype.kind in "biufc"
    if array.dtype.kind not in "biuf":
        return False
    if dtype is DType.F32:
        return True
    if dtype is DType.BOOL:
        return array.dtype.kind == "b"
    if array.dtype.kind == "f":
        return False
    limits = np.iinfo(dtype.value)
    return limits.min <= int(array[()]) <= limits.max


def _in_c_order(array: Array) -> Array:
    return np.asarray(array, order="C")
