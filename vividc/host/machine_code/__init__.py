"""Functions over flat arrays as machine code: inner loops that are too slow in Python.

A function is written in Python, over numbers, C-contiguous arrays, and named tuples of them; its
annotations say which, an array's as `Annotated[..., rank]` if it has more than one dimension. What
is compiled is a small part of Python, with its meaning, but for three things: integers have 64
bits and wrap, no divisor is 0, and no index is out of bounds. All that a folder compiles is one
module of LLVM's, and each function is in it once: tuples go to functions by address.

Numba did the same in 20 s of CPU time for the mapper's annealer, which takes 1 s here, or 0.4 s
with few optimisations, which do for most of its users: it writes an array as seven words, copies
all arrays of a tuple for a call unless it puts the callee into the caller, and so optimised forty
times the code.

In order: `types` (what values are), `body` (LLVM IR under construction), `expressions`,
`statements`, `unit` (which functions there are, and a module of them), `origin` (what they follow
from), `assembler` (LLVM), `shipped` (what comes with an installation), `door` (where Python calls).
"""

from vividc.host.machine_code.door import Compiler, units
from vividc.host.machine_code.unit import inlined

__all__ = ["Compiler", "inlined", "units"]
