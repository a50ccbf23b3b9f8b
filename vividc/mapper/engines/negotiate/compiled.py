"""Where the annealer and the router meet machine code."""

from __future__ import annotations

from typing import Final

from vividc.host.machine_code import Compiler, inlined

__all__ = ["compiled", "inlined", "prepare"]

compiled: Final = Compiler(soon=True)
prepare: Final = compiled.prepare
"""Compile it now, once an installation, and not at the first call."""
