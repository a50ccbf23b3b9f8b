"""What follows from a fabric alone is computed once for each."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial, wraps
from typing import TypeVar

from vividc.arch.fabric import Fabric

_Result = TypeVar("_Result")


def once_a_fabric(function: Callable[[Fabric], _Result]) -> Callable[[Fabric], _Result]:
    """`function`, whose result is kept as long as the fabric lives: nobody may change it.

    By the fabric's identity: equal fabrics are not looked for (a fabric has no hash). A result that
    leads to the fabric would keep it for ever. What lets results go is not Python code: an
    interrupt that came to it would be lost.
    """
    results: dict[int, tuple[weakref.ref[Fabric], _Result]] = {}

    @wraps(function)
    def kept(fabric: Fabric) -> _Result:
        key = id(fabric)
        if key not in results:
            result = function(fabric)
            results[key] = weakref.ref(fabric, partial(results.pop, key)), result
        return results[key][1]

    return kept
