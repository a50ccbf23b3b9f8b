"""What follows from a fabric alone is computed once for each."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Final, TypeVar

from vividc.arch.fabric import Fabric

_Result = TypeVar("_Result")
_KEPT: Final = "_kept_by_mapper"


def once_a_fabric(function: Callable[[Fabric], _Result]) -> Callable[[Fabric], _Result]:
    """`function`, whose result is kept beside the fabric's own cached properties: nobody may change
    it. A fabric has a mapping for latencies and cannot be hashed.
    """

    @wraps(function)
    def kept(fabric: Fabric) -> _Result:
        results = vars(fabric).setdefault(_KEPT, {})
        if function not in results:
            results[function] = function(fabric)
        found: _Result = results[function]
        return found

    return kept
