"""vividc: a compiler, mapper and simulator for coarse-grained reconfigurable arrays."""

import sys

if sys.argv[:1] == ["-m"] and "vividc" in sys.orig_argv[1:4]:
    # `python -m vividc` loads this package before its `__main__`.
    import vividc_main

    vividc_main.leave_on_interrupt()

from vividc import arch, dfg, lang, launch, mapper, program
from vividc.compiler.advice.advise import Hint, advise
from vividc.compiler.driver import compile
from vividc.compiler.planning.options import LoopOptions
from vividc.errors import VividcError, VividcWarning
from vividc.frontend import KernelFunction, LLKernel, kernel, load_ll
from vividc.gemm.kernels.simulate import simulate
from vividc.host.time_limit import patient
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
    "kernel",
    "lang",
    "launch",
    "load",
    "load_ll",
    "mapper",
    "patient",
    "program",
    "simulate",
]
