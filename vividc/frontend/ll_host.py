"""A C kernel on the host, compiled by LLVM from the same `.ll` file: the reference that `--check`
and the tests compare with.

It shares nothing with the compiler but the file: the module is taken as clang wrote it, with
64-bit pointers, 64-bit integers and doubles.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import binding

_TARGET = re.compile(r"^target (?:datalayout|triple)\b.*$", re.MULTILINE)
_FEATURES = re.compile(r'"(?:target-cpu|target-features|tune-cpu)"="[^"]*"')
_CTYPES: dict[str, Any] = {
    "i1": ctypes.c_bool,
    "i8": ctypes.c_int8,
    "i16": ctypes.c_int16,
    "i32": ctypes.c_int32,
    "i64": ctypes.c_int64,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "ptr": ctypes.c_void_p,
    "void": None,
}


_UNSIGNED: dict[str, Any] = {
    "i8": ctypes.c_uint8,
    "i16": ctypes.c_uint16,
    "i32": ctypes.c_uint32,
    "i64": ctypes.c_uint64,
}


class HostFunction:
    """A function of a module, compiled for this computer."""

    def __init__(
        self, text: str, name: str, params: Sequence[str], returns: str, *, unsigned: bool
    ) -> None:
        """`params`, `returns`: LLVM types. `unsigned`: of the returned integer."""
        self._engine = _compiled(text)
        address = self._engine.get_function_address(name)
        result = (_UNSIGNED if unsigned else _CTYPES)[returns]
        types = [_CTYPES[param] for param in params]
        self._function = ctypes.CFUNCTYPE(result, *types)(address)

    def __call__(self, *args: object) -> object:
        """Run it on checked arguments; arrays are updated in place."""
        result: object = self._function(*map(_argument, args))
        return result


def _argument(value: object) -> object:
    if isinstance(value, np.ndarray):
        return value.ctypes.data_as(ctypes.c_void_p)
    return value.item() if isinstance(value, np.generic) else value


def _compiled(text: str) -> Any:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    library = ctypes.util.find_library("m")
    if library is not None:
        binding.load_library_permanently(library)
    module = binding.parse_assembly(_FEATURES.sub("", _TARGET.sub("", text)))
    machine = binding.Target.from_default_triple().create_target_machine(opt=1)
    engine = binding.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine
