"""The only place where the timing of jobs meets machine code."""

from __future__ import annotations

from typing import Final

from vividc.host.machine_code import Compiler, inlined

__all__ = ["compiled", "inlined"]

compiled: Final = Compiler()
