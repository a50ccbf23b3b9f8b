"""The native engine: a program's configuration words as machine code of this computer.

In order: `plan/` (what it will do), `state` (memory), `write/` and `bulk/` (as LLVM IR), `region`,
`module`, `compiler`, `code` (compiled, or from the cache), `fallback` (a region on the reference
engine), `spans` (for observers), `engine`.
"""

from vividc.sim.native.engine import NativeEngine

__all__ = ["NativeEngine"]
