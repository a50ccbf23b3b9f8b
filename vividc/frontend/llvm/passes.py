"""LLVM's passes over a kernel: everything is inlined into one function, which is cleaned up.

Also runs in the process of `llvm_child`, so it imports llvmlite and nothing else.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable

from llvmlite import binding

ENTRY = "vividc.entry"
DATA_LAYOUT = "e-p:32:32-i64:64-n32"
"""Pointers of 32 bits: LLVM then truncates address arithmetic to the machine's words by itself."""
_DECLARE = re.compile(r"^.*llvm\.dbg\.(declare|value).*\n", re.MULTILINE)


def linked_ir(entry: str, parts: Iterable[str]) -> str:
    """Inline all functions of the modules `parts` into `ENTRY` of the module `entry`, and optimise.

    Returns
    -------
    str
        Text of a module.
    """
    linked = parse(entry)
    for part in parts:
        linked.link_in(parse(_DECLARE.sub("", part)))
    for function in linked.functions:
        if not function.is_declaration and function.name != ENTRY:
            function.linkage = "internal"
            function.add_function_attribute("alwaysinline")
    _optimise(linked)
    return str(linked)


def parse(text: str) -> binding.ModuleRef:
    """A module of the machine's data layout.

    Raises
    ------
    RuntimeError
        LLVM cannot read the text; it says why, with line and column.
    """
    _initialise()
    module = binding.parse_assembly(text)
    module.data_layout = DATA_LAYOUT
    return module


@functools.cache
def _initialise() -> None:
    binding.initialize_native_target()


def _optimise(module: binding.ModuleRef) -> None:
    """Loops keep their while form: no rotation, threading, unrolling or vectorising."""
    target = binding.Target.from_default_triple()
    machine = target.create_target_machine(cpu="", features="", opt=1)
    options = binding.create_pipeline_tuning_options(speed_level=1)
    builder = binding.create_pass_builder(machine, options)
    passes = binding.create_new_module_pass_manager()
    passes.add_always_inliner_pass()
    passes.add_global_dead_code_eliminate_pass()
    for _ in range(2):
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_instruction_combine_pass()
        passes.add_new_gvn_pass()
        passes.add_sccp_pass()
        passes.add_dead_store_elimination_pass()
        passes.add_aggressive_dce_pass()
    passes.add_simplify_cfg_pass()
    passes.add_instruction_combine_pass()
    passes.add_simplify_cfg_pass()
    passes.add_lower_switch_pass()
    passes.add_dead_code_elimination_pass()
    passes.add_loop_simplify_pass()
    passes.run(module, builder)
