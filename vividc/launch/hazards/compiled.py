"""The only place where the check of graphs meets machine code."""

from __future__ import annotations

from typing import Final

from vividc.host.machine_code import Compiler, compiler

compiled: Final[Compiler] = compiler(__file__)
