"""What is done for the client, each request in a process of its own: read a module, optimise a
kernel, run one.

Imports llvmlite and Python's own modules only: the server starts in a tenth of a second.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import mmap
import os
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import binding

from vividc.frontend.llvm.child.messages import Header, send, writer
from vividc.frontend.llvm.passes import linked_ir, parse

MATH = frozenset(
    [
        "exp",
        "exp2",
        "log",
        "log2",
        "log10",
        "sqrt",
        "pow",
        "fma",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "floor",
        "ceil",
        "trunc",
        "round",
        "rint",
        "nearbyint",
        "roundeven",
        "fabs",
        "copysign",
        "fmin",
        "fmax",
        "expm1",
        "log1p",
        "hypot",
        "fmod",
        "ldexp",
    ]
)
"""Functions of `math.h`, each also for float with an f behind its name: all of C's library that a
kernel can call."""
FAULT, REFERENCE, ARRAYS, HOST = "vividc.fault", "vividc.reference", "vividc.arrays", "vividc.host."
"""Names in a module to run: what reports a fault, the kernel, the table of its arrays' places, and
before the name of each function of `MATH`."""
_GAP = 1 << 16
_TYPES: dict[str, Any] = {
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
Answer = tuple[Header, Sequence[bytes]]


def prepare() -> None:
    """What all requests need, once for all."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


def _read(header: Header, blobs: list[bytes], sink: int) -> Answer:
    """The module as LLVM prints it: one instruction a line."""
    try:
        module = parse(header["text"])
        module.verify()
    except RuntimeError as error:
        return {"error": str(error), "kind": "text"}, []
    return {"text": str(module)}, []


def _link(header: Header, blobs: list[bytes], sink: int) -> Answer:
    """`linked_ir`."""
    try:
        return {"text": linked_ir(header["entry"], header["parts"])}, []
    except RuntimeError as error:
        return {"error": str(error), "kind": "text"}, []


def _run(header: Header, blobs: list[bytes], sink: int) -> Answer:
    """Run `REFERENCE` of a module on arrays in memory of its own.

    The header has "params" and "returns" (LLVM types), "unsigned" (the result is), "arguments":
    numbers, and for a pointer a block of bytes, an offset in it and a size. An access outside the
    arrays ends the process through `FAULT`, with the number that the module gives it.
    """

    def fault(place: int) -> None:
        send(writer(sink), {"error": "", "kind": "fault", "place": place}, [])
        os._exit(0)

    callback = ctypes.CFUNCTYPE(None, ctypes.c_int64)(fault)
    engine = _compiled(header["text"], ctypes.cast(callback, ctypes.c_void_p).value)
    memory, starts = _placed(blobs)
    arguments: list[Any] = []
    places: list[int] = []
    for argument in header["arguments"]:
        if isinstance(argument, list):
            block, offset, size = argument
            arguments.append(starts[block] + offset)
            places += [arguments[-1], size]
        else:
            arguments.append(argument)
    table = engine.get_global_value_address(ARRAYS)
    ctypes.memmove(table, (ctypes.c_uint64 * len(places))(*places), 8 * len(places))
    result = (_UNSIGNED if header["unsigned"] else _TYPES)[header["returns"]]
    types = [_TYPES[param] for param in header["params"]]
    function = ctypes.CFUNCTYPE(result, *types)(engine.get_function_address(REFERENCE))
    value = function(*arguments)
    first = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    after = [memory[start - first :][: len(b)] for start, b in zip(starts, blobs, strict=True)]
    return {"value": value}, after


def _compiled(text: str, fault: int | None) -> Any:
    binding.add_symbol(FAULT, fault)
    library = ctypes.CDLL(ctypes.util.find_library("m") or None)
    for name in (*MATH, *(f"{name}f" for name in MATH)):
        if hasattr(library, name):
            binding.add_symbol(HOST + name, ctypes.cast(library[name], ctypes.c_void_p).value)
    module = binding.parse_assembly(text)
    module.verify()
    machine = binding.Target.from_default_triple().create_target_machine(opt=1)
    engine = binding.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine


def _placed(blobs: list[bytes]) -> tuple[mmap.mmap, list[int]]:
    """Memory with the blocks in it, far from each other, and their addresses."""
    offsets, size = [], _GAP
    for blob in blobs:
        offsets.append(size)
        size += -(-len(blob) // _GAP) * _GAP + _GAP
    memory = mmap.mmap(-1, size)
    for offset, blob in zip(offsets, blobs, strict=True):
        memory[offset : offset + len(blob)] = blob
    first = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    return memory, [first + offset for offset in offsets]


WORK: dict[str, Callable[[Header, list[bytes], int], Answer]] = {
    "read": _read,
    "link": _link,
    "run": _run,
}
