"""`load_ll`: a C function, as clang's LLVM IR in a `.ll` file, as a kernel."""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vividc.errors import ArgumentError, KernelError, SourceLoc, demand_type
from vividc.frontend.c.host import HostFunction
from vividc.frontend.c.lower import CModule, declare, lower_c, with_scalars
from vividc.frontend.c.places import instruction_lines
from vividc.frontend.c.reference import reference_text
from vividc.frontend.c.source import bodies, located_module, printed, read_ll
from vividc.frontend.like import Like, with_sizes
from vividc.frontend.llvm.metadata import Locations
from vividc.machine.params import DType, Param
from vividc.ssa.ir import Function

_ELEMENTS = ("float32", "bool", "int8", "uint8", "int16", "uint16", "int32", "uint32")
_TYPES = {"ptr": _ELEMENTS, "i64": ("int64", "uint64"), "i32": ("int32", "uint32")}
_TYPES |= {"float": ("float32",), "i1": ("bool",)}


class LLKernel:
    """A C function of a `.ll` file. `vividc.compile` takes it like a kernel in Python; calling it
    runs it on the host, compiled by LLVM from the same file.

    Attributes
    ----------
    name
        The function's name.
    params
        Its parameters in order, with the scalars that are known. A pointer is an array of any
        number of dimensions.
    file
        The `.ll` file.
    line
        Where the function is defined, in the C file if the debug information says, else in `file`.
    """

    def __init__(self, module: CModule) -> None:
        self._module = module
        self._sized: dict[tuple[Param, ...], LLKernel] = {}
        self.name = module.function.symbol
        self.file = module.file
        self.line = module.function.loc.line
        self.params = module.params
        self._lowered: dict[bool, Function] = {}

    def sized(self, like: Like) -> LLKernel:
        """The kernel for scalars that are known, as of `vividc.compile`. Of an array that is given
        nothing is taken: C knows no shapes.

        Raises
        ------
        ArgumentError
            They do not fit its parameters.
        """
        params = with_sizes(self.name, self.params, like)
        if params not in self._sized:
            known = {param.name: param.known[0] for param in params if param.known}
            self._sized[params] = LLKernel(with_scalars(self._module, known))
        return self._sized[params]

    @property
    def loc(self) -> SourceLoc:
        """Where the function is defined."""
        return self._module.function.loc

    def __repr__(self) -> str:
        return f"<C kernel {self.name} of {self.file}>"

    def lower(self, strict_fp: bool = False) -> Function:
        """The function as SSA words, once per option.

        Parameters
        ----------
        strict_fp
            Refuse double arithmetic; else it runs in float32 with a warning for each line.

        Raises
        ------
        KernelError
            The function uses something that cannot be compiled.
        """
        if strict_fp not in self._lowered:
            self._lowered[strict_fp] = lower_c(self._module, strict_fp=strict_fp)
        return self._lowered[strict_fp]

    def __call__(self, *args: Any) -> Any:
        """Run the function on this computer; arrays are updated in place.

        Raises
        ------
        ArgumentError
            An argument is not what its parameter takes.
        """
        if len(args) != len(self.params):
            names = ", ".join(param.name for param in self.params)
            raise ArgumentError(f"{self.name}({names}) got {len(args)} arguments")
        for param, value in zip(self.params, args, strict=True):
            _check(param, value)
        return self._host(*args)

    @functools.cached_property
    def _host(self) -> HostFunction:
        module, function = self._module, self._module.function
        return HostFunction(
            reference_text(module.text, self.name, Locations(module.text, function.loc.file)),
            [param.type for param in function.params],
            function.returns,
            unsigned=function.result in (DType.U32, DType.U64)
            or (function.returns in ("i8", "i16") and not function.signed),
            loc=function.loc,
        )


def load_ll(
    path: str | os.PathLike[str],
    function: str | None = None,
    *,
    types: Mapping[str, str] | None = None,
) -> LLKernel:
    """A C function of a `.ll` file, as `clang -O1 -emit-llvm -S` writes it, as a kernel.

    Parameters
    ----------
    path
        The `.ll` file.
    function
        Name of the function; may be left out if the file defines one that others can call.
    types
        "float32", "bool", or "int" or "uint" with 8, 16, 32 or (scalars only) 64 bits, by parameter
        name: for those whose type neither the debug information (`clang -g`) nor the accesses tell.

    Returns
    -------
    LLKernel
        Its parameters are named as in C with debug information, else as in the IR, else "arg0",
        "arg1", ...

    Raises
    ------
    KernelError
        The file cannot be read or is no LLVM IR with opaque pointers, has no such function, or the
        function uses what the array cannot run.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    place = Path(path)
    source = read_ll(place)
    text = located_module(printed(source, place), place, instruction_lines(source))
    name, file = function or _only(text, place), os.path.abspath(place)
    module = declare(text, file, name)
    if not types:
        return LLKernel(module)
    _check_types(module, types)
    return LLKernel(declare(text, file, name, types))


def _only(source: str, path: Path) -> str:
    """The file's one function that is not static."""
    names = [b.name for b in bodies(source) if not re.search(r"\b(internal|private)\b", b.lines[0])]
    if len(names) == 1:
        return names[0]
    if not names:
        raise KernelError("defines no function", loc=str(path), hint="compile a file that does")
    reason = f"has several functions: {', '.join(names)}"
    raise KernelError(reason, loc=str(path), hint=f"choose one: {path}:{names[0]}")


def _check_types(module: CModule, types: Mapping[str, str]) -> None:
    params = {param.name: param for param in module.function.params}
    for name, dtype in types.items():
        takes = _TYPES.get(params[name].type, ()) if name in params else ()
        if dtype not in takes:
            known = ", ".join(takes or params) or "nothing"
            hint = f"give {known}" if name in params else f"its parameters: {known}"
            raise KernelError(f"types: {name!r}: {dtype!r}", loc=module.function.loc, hint=hint)


def _check(param: Param, value: object) -> None:
    where = f"argument {param.name}"
    if not param.ndim:
        if not isinstance(value, int | float | np.generic):
            raise ArgumentError(f"expected a {param.dtype.value}", loc=where)
        return
    if (
        not isinstance(value, np.ndarray)
        or value.dtype != np.dtype(param.dtype.value)
        or not value.flags.c_contiguous
    ):
        reason = f"expected a C-contiguous {param.dtype.value} array"
        hint = f"pass np.ascontiguousarray({param.name}, np.{param.dtype.value})"
        raise ArgumentError(reason, loc=where, hint=hint)
