"""What follows from one object that never changes is computed once for it."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial, wraps
from typing import TypeVar

_Object = TypeVar("_Object")
_Result = TypeVar("_Result")


def once_each(function: Callable[[_Object], _Result]) -> Callable[[_Object], _Result]:
    """`function`, whose result is kept as long as the object lives: nobody may change it.

    By the object's identity: equal ones are not looked for (a fabric has no hash, and comparing
    SSA functions takes longer than most analyses). A result that leads to the object would keep it
    for ever. What lets results go is not Python code: an interrupt that came to it would be lost.
    """
    results: dict[int, tuple[weakref.ref[_Object], _Result]] = {}

    @wraps(function)
    def kept(given: _Object) -> _Result:
        key = id(given)
        if key not in results:
            result = function(given)
            results[key] = weakref.ref(given, partial(results.pop, key)), result
        return results[key][1]

    return kept
