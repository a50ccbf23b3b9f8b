"""The only place where the mapper meets numba: functions over flat arrays become machine code.

They allocate nothing, so reference counting is off: counting the arrays of every argument took
nineteen twentieths of the time. Divisors are never 0, so none is checked.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba

_Function = TypeVar("_Function", bound=Callable[..., object])

_OPTIONS: Final[dict[str, Any]] = {"error_model": "numpy", "_nrt": False}


def _package_stamp() -> str:
    text = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        text.update(path.read_bytes())
    return text.hexdigest()


_STAMP: Final = _package_stamp()


def compiled(function: _Function) -> _Function:
    """The function as machine code, compiled at its first call and kept on disk where that is
    possible; where no directory can be written it is compiled again in each process.

    Code on disk holds the functions that it calls, too, whatever file they are in: it is good for
    this state of the whole package only, which numba by itself would not notice.
    """
    try:
        made = numba.njit(cache=True, **_OPTIONS)(function)
        made._cache._cache_file._source_stamp = _STAMP
    except RuntimeError:  # numba found no place for its cache
        made = numba.njit(**_OPTIONS)(function)
    return cast(_Function, made)
