"""The only place where the mapper meets numba: functions over flat arrays become machine code."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

_Function = TypeVar("_Function", bound=Callable[..., object])


def compiled(function: _Function) -> _Function:
    """The function as machine code, compiled at its first call and kept on disk where that is
    possible; where no directory can be written it is compiled again in each process.
    """
    try:
        made = numba.njit(cache=True, _nrt=False)(function)
    except RuntimeError:  # numba found no place for its cache
        made = numba.njit(function)
    return cast(_Function, made)
