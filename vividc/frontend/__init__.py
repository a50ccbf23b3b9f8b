"""From a Python function or a `.ll` file to SSA: `@kernel` and `load_ll`, and what they give.

In order: `kernel`, `like` (sizes that are known), `arguments` (tuples, None and strings); `numba/`
(a function typed by numba) and `c/` (a file of clang's); `llvm/` (passes, and the reader of what
they leave); `memory/` (pointers become accesses of arrays), `ranges/` (which values integers have),
`narrow/` (64 bits become words); `stages`, the list of them in order, and `lower`, which runs it;
`advice` (hints for Python and for C); `refused/` (what numba refuses, in the user's words).
"""

from vividc.frontend.c.kernel import LLKernel, load_ll
from vividc.frontend.kernel import KernelFunction, kernel

__all__ = ["KernelFunction", "LLKernel", "kernel", "load_ll"]
