"""From a function to SSA: `@kernel` and `load_ll`, and what they give."""

from vividc.frontend.kernel import KernelFunction, kernel
from vividc.frontend.ll_kernel import LLKernel, load_ll

__all__ = ["KernelFunction", "LLKernel", "kernel", "load_ll"]
