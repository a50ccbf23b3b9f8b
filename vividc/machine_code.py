"""Functions over flat arrays as machine code: inner loops that are too slow in Python.

They allocate nothing, so reference counting is off: counting the arrays of every argument took
nineteen twentieths of the time. Divisors are never 0, so none is checked.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Protocol, TypeVar, cast

import numba
import numba.extending
import numpy as np

_Function = TypeVar("_Function", bound=Callable[..., object])

_OPTIONS: Final[dict[str, Any]] = {
    "error_model": "numpy",
    "nogil": True,
    "_nrt": False,
    "no_cfunc_wrapper": True,
}


class Compiler(Protocol):
    """A decorator that keeps a function's type."""

    def __call__(self, function: _Function, /) -> _Function: ...


def compiler(module: str) -> Compiler:
    """Return the decorator of a folder's functions; `module` is the `__file__` of a module there.

    A function is compiled at its first call and kept on disk where that is possible; where no
    directory can be written it is compiled again in each process.

    Code on disk holds the functions that it calls, too, whatever file they are in: it is good for
    this state of the whole folder and of this file only, which numba by itself would not notice.
    """
    stamp = _stamp(Path(module).parent)

    def compiled(function: _Function) -> _Function:
        try:
            made = numba.njit(cache=True, **_OPTIONS)(function)
            made._cache._cache_file._source_stamp = stamp
        except RuntimeError:  # numba found no place for its cache
            made = numba.njit(**_OPTIONS)(function)
        return cast(_Function, made)

    return compiled


def inlined(function: _Function) -> _Function:
    """Have a function put into each compiled one that calls it; called by Python it is Python.

    A call would copy every array of every tuple it is given, some hundred words each: that took two
    thirds of the annealer's time.
    """
    jitable = numba.extending.register_jitable(
        forceinline=True, no_cpython_wrapper=True, **_OPTIONS
    )
    return cast(_Function, jitable(function))


def constant(number: int) -> int:
    """Return a number such that functions it is passed to are compiled once, not anew for it."""
    return cast(int, np.int64(number))


def _stamp(folder: Path) -> str:
    text = hashlib.sha256()
    for path in (Path(__file__), *sorted(folder.glob("*.py"))):
        text.update(path.read_bytes())
    return text.hexdigest()
