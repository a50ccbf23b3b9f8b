"""LLVM IR of programs to machine code, and into this process."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Final

from llvmlite import binding

from vividc.host.machine_code import assembler
from vividc.sim.native.module import ENTRY

Native = Callable[[int, int, int], int]
"""`run` of `native.module`, with addresses for pointers; it holds no lock of Python's."""

_LARGE: Final = 500_000
"""Characters of a module from which LLVM's code generator does not optimise: its time for a loop of
thousands of operations grows faster than the loop.
"""


@functools.cache
def host() -> str:
    """What machine code depends on: LLVM, processor, features, byte order, and this file."""
    return f"{assembler.host()}|{sha256(Path(__file__).read_bytes()).hexdigest()}"


def object_code(text: str) -> bytes:
    """Machine code of a module, as an object file."""
    with assembler.LOCK:
        machine = assembler.target_machine(2 if len(text) < _LARGE else 0)
        module = assembler.parsed(text, machine)
        _simplify(
            module, binding.create_pass_builder(machine, binding.create_pipeline_tuning_options())
        )
        code: bytes = machine.emit_object(module)
        return code


def _simplify(module: binding.ModuleRef, builder: binding.PassBuilder) -> None:
    """The text is in SSA and has little redundancy: a full pipeline takes three times as long, and
    makes code that is no faster.
    """
    passes = binding.create_new_function_pass_manager()
    passes.add_simplify_cfg_pass()
    passes.add_instruction_combine_pass()
    passes.add_dead_code_elimination_pass()
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


def loaded(code: bytes, name: str) -> Native:
    """The function `run` of an object file; `name` is used once in a process."""
    alive, (address,) = assembler.linked(code, name, [ENTRY])
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 3)(address)

    def run(context: int, constants: int, memory: int) -> int:
        assert alive is not None  # the code lives as long as this
        status: int = function(context, constants, memory)
        return status

    return run
