"""The only place where the mapper deals with machine code, that of the annealer and router."""

from __future__ import annotations

from typing import Final

from vividc.host.machine_code import Compiler, compiler, inlined

__all__ = ["compiled", "inlined"]

compiled: Final[Compiler] = compiler(__file__)
