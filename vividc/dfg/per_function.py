"""What follows from a function alone is computed once for each."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial, wraps
from typing import TypeVar

from vividc import time_limit
from vividc.dfg.cfg import Function

_Result = TypeVar("_Result")


def once_a_function(analysis: Callable[[Function], _Result]) -> Callable[[Function], _Result]:
    """`analysis`, whose result is kept as long as the function lives: nobody may change it.

    By the function's identity: comparing functions takes longer than most analyses. A result that
    leads to the function would keep it for ever. What lets results go is not Python code, as an
    interrupt that came to it would be lost.
    """
    results: dict[int, tuple[weakref.ref[Function], _Result]] = {}

    @wraps(analysis)
    def kept(function: Function) -> _Result:
        key = id(function)
        if key not in results:
            time_limit.step("control flow was analysed")
            result = analysis(function)
            results[key] = weakref.ref(function, partial(results.pop, key)), result
        return results[key][1]

    return kept
