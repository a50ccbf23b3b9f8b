"""vividc: a compiler, mapper and simulator for coarse-grained reconfigurable arrays.

Compilers and solvers take a second to load, and are when they are used.
"""

from typing import TYPE_CHECKING

from vividc.errors import VividcError, VividcWarning
from vividc.host.lazy import lazily

if TYPE_CHECKING:
    from vividc import arch, dfg, lang, launch, mapper, program
    from vividc.compiler.advice.advise import Hint, advise
    from vividc.compiler.driver import compile
    from vividc.compiler.jit import jit
    from vividc.compiler.planning.options import LoopOptions
    from vividc.frontend import KernelFunction, LLKernel, load_ll
    from vividc.frontend.kernel import kernel
    from vividc.gemm.kernels.simulate import simulate
    from vividc.host.progress import progress
    from vividc.host.time_limit import patient
    from vividc.page.write import view
    from vividc.program import Program, load
    from vividc.sim import Result

__version__ = "0.1.0"

__all__ = [
    "Hint",
    "KernelFunction",
    "LLKernel",
    "LoopOptions",
    "Program",
    "Result",
    "VividcError",
    "VividcWarning",
    "__version__",
    "advise",
    "arch",
    "compile",
    "dfg",
    "jit",
    "kernel",
    "lang",
    "launch",
    "load",
    "load_ll",
    "mapper",
    "patient",
    "program",
    "progress",
    "simulate",
    "view",
]

_ROOMS = ("arch", "dfg", "lang", "launch", "mapper", "program")
_HOMES = {
    "vividc.compiler.advice.advise": ("Hint", "advise"),
    "vividc.compiler.driver": ("compile",),
    "vividc.compiler.jit": ("jit",),
    "vividc.compiler.planning.options": ("LoopOptions",),
    "vividc.frontend": ("KernelFunction", "LLKernel", "kernel", "load_ll"),
    "vividc.gemm.kernels.simulate": ("simulate",),
    "vividc.host.progress": ("progress",),
    "vividc.host.time_limit": ("patient",),
    "vividc.page.write": ("view",),
    "vividc.program": ("Program", "load"),
    "vividc.sim": ("Result",),
}

if not TYPE_CHECKING:  # which would take any name then
    __getattr__, __dir__ = lazily(__name__, _HOMES, _ROOMS)
