"""The length of a kernel: what no array can hold is refused before time is spent on it."""

from __future__ import annotations

from types import FunctionType
from typing import Final

from vividc.errors import KernelError, SourceLoc
from vividc.ssa.ir import Function

MAX_INSTRUCTIONS: Final = 8192
"""Of a function with all that it calls: what 16 PEs of 512 contexts hold."""
MAX_BLOCKS: Final = 1024
MAX_BYTECODE: Final = 65536
"""Instructions of Python's: some eight for each of the array's."""
_BYTES: Final = 2
_HINT: Final = "make several kernels of it, or loops of what repeats"


def refuse_long(wide: Function, loc: SourceLoc) -> None:
    """Refuse a function that is longer than the array.

    Raises
    ------
    KernelError
        It has too many instructions or blocks.
    """
    _demand(sum(len(block.items) for block in wide.blocks), MAX_INSTRUCTIONS, "instructions", loc)
    _demand(len(wide.blocks), MAX_BLOCKS, "blocks", loc)


def refuse_long_code(py_func: object, loc: SourceLoc) -> None:
    """Refuse a Python function of which no pass of numba's would end soon; `refuse_long` of it."""
    if isinstance(py_func, FunctionType):
        count = len(py_func.__code__.co_code) // _BYTES
        _demand(count, MAX_BYTECODE, "Python instructions", loc)


def _demand(count: int, most: int, what: str, loc: SourceLoc) -> None:
    if count > most:
        reason = f"a function of {count} {what}, where {most} are the most"
        raise KernelError(reason, loc=loc, hint=_HINT)
