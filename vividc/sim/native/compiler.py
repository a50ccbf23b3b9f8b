"""LLVM IR to machine code, and into this process.

The only module that talks to llvmlite for writing code.
"""

from __future__ import annotations

import ctypes
import functools
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Final

from llvmlite import binding

from vividc.sim.native.module import ENTRY

Native = Callable[[int, int, int], int]
"""`run` of `native.module`, with addresses for pointers; it holds no lock of Python's."""

_LOCK: Final = Lock()

_LARGE: Final = 500_000
"""Characters of a module from which LLVM's code generator does not optimise: its time for a loop of
thousands of operations grows faster than the loop.
"""


@functools.cache
def host() -> str:
    """What machine code depends on: LLVM, processor, features, byte order, and this file."""
    version = ".".join(map(str, binding.llvm_version_info))
    features = binding.get_host_cpu_features().flatten()
    return "|".join(
        (
            version,
            binding.get_process_triple(),
            binding.get_host_cpu_name(),
            features,
            sys.byteorder,
            sha256(Path(__file__).read_bytes()).hexdigest(),
        )
    )


def object_code(text: str) -> bytes:
    """Machine code of a module, as an object file."""
    with _LOCK:
        machine = _target_machine(2 if len(text) < _LARGE else 0)
        module = binding.parse_assembly(text)
        module.triple = binding.get_process_triple()
        module.data_layout = str(machine.target_data)
        module.verify()
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
    with _LOCK:
        library = binding.JITLibraryBuilder()
        library.add_object_img(code).add_current_process().export_symbol(ENTRY)
        tracker = library.link(_jit(), name)
    prototype = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 3)
    function = prototype(tracker[ENTRY])

    def run(context: int, constants: int, memory: int) -> int:
        assert tracker is not None  # the code lives as long as its tracker
        status: int = function(context, constants, memory)
        return status

    return run


@functools.cache
def _initialize() -> None:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


@functools.cache
def _target_machine(opt: int) -> binding.TargetMachine:
    _initialize()
    target = binding.Target.from_default_triple()
    return target.create_target_machine(
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
        opt=opt,
        jit=True,
    )


@functools.cache
def _jit() -> binding.LLJIT:
    _initialize()
    return binding.create_lljit_compiler()
