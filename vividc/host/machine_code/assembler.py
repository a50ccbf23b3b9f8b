"""LLVM IR as text to machine code of this computer, and machine code into this process."""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterable
from threading import Lock
from typing import Any, Final

from llvmlite import binding

LOCK: Final = Lock()
"""Held by who uses a machine: two threads may not at the same time."""
_LEVEL, _PORTABLE_LEVEL = 1, 2
"""Of optimisation, and of code that comes with an installation. The second takes twice the time for
the annealer, which is 3 to 6 % faster with it; the third is no faster.
"""


@functools.cache
def host() -> str:
    """What machine code depends on beside its text: LLVM, processor, features, byte order."""
    return "|".join(
        (
            ".".join(map(str, binding.llvm_version_info)),
            binding.get_process_triple(),
            binding.get_host_cpu_name(),
            binding.get_host_cpu_features().flatten(),
            sys.byteorder,
        )
    )


def platform() -> str:
    """Architecture and system, which portable machine code depends on."""
    triple: str = binding.get_process_triple()
    return triple


def optimised(text: str, *, in_vectors: bool, portable: bool = False) -> bytes:
    """Machine code of a module, as an object file.

    Parameters
    ----------
    in_vectors
        Whether loops may be unrolled and made to compute vectors, which takes half the time again.
    portable
        For any processor of this architecture. Annealing takes the same time with it.
    """
    with LOCK:
        machine = target_machine(2, portable)
        module, level = parsed(text, machine), _PORTABLE_LEVEL if portable else _LEVEL
        options = binding.create_pipeline_tuning_options(speed_level=level)
        options.loop_vectorization = options.loop_unrolling = in_vectors
        builder = binding.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
        code: bytes = machine.emit_object(module)
        return code


def quickly(text: str) -> bytes:
    """The same with few optimisations: made in a third of the time, it takes a quarter longer."""
    with LOCK:
        machine = target_machine(1)
        module = parsed(text, machine)
        builder = binding.create_pass_builder(machine, binding.create_pipeline_tuning_options())
        passes = binding.create_new_module_pass_manager()
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_instruction_combine_pass()
        passes.run(module, builder)
        code: bytes = machine.emit_object(module)
        return code


def parsed(text: str, machine: binding.TargetMachine) -> binding.ModuleRef:
    """A module for a machine, in a context of its own: numba's is used by other threads."""
    module = binding.parse_assembly(text, binding.create_context())
    module.triple = binding.get_process_triple()
    module.data_layout = str(machine.target_data)
    module.verify()
    return module


@functools.cache
def target_machine(level: int, portable: bool = False) -> binding.TargetMachine:
    """This computer, or any of its architecture, for code generation of a level from 0 to 3."""
    _initialize()
    target = binding.Target.from_default_triple()
    if portable:
        return target.create_target_machine(opt=level, jit=True)
    return target.create_target_machine(
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
        opt=level,
        jit=True,
    )


def linked(code: bytes, name: str, symbols: Iterable[str]) -> tuple[Any, list[int]]:
    """The addresses of functions of an object file, which live as long as what comes before them;
    `name` is used once in a process.
    """
    wanted = list(symbols)
    with LOCK:
        library = binding.JITLibraryBuilder()
        library.add_object_img(code).add_current_process()
        for symbol in wanted:
            library.export_symbol(symbol)
        tracker = library.link(_jit(), name)
    return tracker, [tracker[symbol] for symbol in wanted]


@functools.cache
def _initialize() -> None:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


@functools.cache
def _jit() -> binding.LLJIT:
    _initialize()
    return binding.create_lljit_compiler()
