"""`np.argsort` of one dimension, in place of numba's, which keeps a list.

Equal elements can be told apart by their indices, so that their order is numba's: that of its
quicksort (Hoare 1962), with the median of three as pivot and insertion in short parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numba.core import types
from numba.core.typing import signature
from numba.extending import register_jitable

from vividc.frontend.numba.library.less import is_greater, is_less, is_less_float
from vividc.lang.numba_types import FormatType

_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable
_SHORT: Final = 15
"""Elements of a part from which on numba's quicksort divides it."""
_DEEP: Final = 32
"""Parts that wait at most: the larger of two does, so that it is as many as an index has bits."""


def is_argsort(operation: object, sig: Any) -> bool:
    """Say whether numba asks for the order of the elements of an array of one dimension, which is
    not to be stable.
    """
    if operation not in ("array.argsort", np.argsort):
        return False
    *_, kind = sig.args or (None,)
    array = sig.recvr or sig.args[0]
    is_quick = getattr(kind, "literal_value", "quicksort") == "quicksort"
    return array.ndim == 1 and is_quick


def argsort(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """The indices of the elements in their order; NaNs come last."""
    array = sig.recvr or sig.args[0]
    rule = argsort_floats if isinstance(array.dtype, types.Float | FormatType) else argsort_up
    inner = signature(sig.return_type, array)
    return context.compile_internal(builder, rule, inner, args[:1])


def _swapped(is_less: Any) -> Any:
    @_helper
    def swap(a: Any, order: Any, first: Any, second: Any) -> None:
        """Put two places in order."""
        if is_less(a[order[second]], a[order[first]]):
            order[first], order[second] = order[second], order[first]

    return swap


def _divided(is_less: Any) -> Any:
    swap = _swapped(is_less)

    @_helper
    def divide(a: Any, order: Any, low: Any, high: Any) -> Any:
        """The place of the pivot, before which nothing is greater, and behind it nothing less."""
        middle = (low + high) >> 1
        swap(a, order, low, middle)
        swap(a, order, middle, high)
        swap(a, order, low, middle)
        pivot = a[order[middle]]
        order[middle], order[high] = order[high], order[middle]
        up, down = low, high - 1
        while True:
            while up < high and is_less(a[order[up]], pivot):
                up += 1
            while down >= low and is_less(pivot, a[order[down]]):
                down -= 1
            if up >= down:
                break
            order[up], order[down] = order[down], order[up]
            up += 1
            down -= 1
        order[up], order[high] = order[high], order[up]
        return up

    return divide


def _inserted(is_less: Any) -> Any:
    @_helper
    def insert(a: Any, order: Any, low: Any, high: Any) -> None:
        """Sort a part by insertion."""
        for place in range(low + 1, high + 1):
            moved = order[place]
            hole = place
            while hole > low and is_less(a[moved], a[order[hole - 1]]):
                order[hole] = order[hole - 1]
                hole -= 1
            order[hole] = moved

    return insert


def _quicksort(is_less: Any) -> Callable[[Any], Any]:
    """`argsort` by numba's choices of pivots."""
    divide, insert = _divided(is_less), _inserted(is_less)

    @_helper
    def argsort(a: Any) -> Any:
        order = np.arange(len(a))
        waiting = np.empty((_DEEP, 2), np.int32)
        waiting[0, 0], waiting[0, 1] = 0, len(a) - 1
        count = 1
        while count > 0:
            count -= 1
            low, high = waiting[count, 0], waiting[count, 1]
            while high - low >= _SHORT:
                at = divide(a, order, low, high)
                if high - at > at - low:
                    waiting[count, 0], waiting[count, 1] = at + 1, high
                    high = at - 1
                else:
                    waiting[count, 0], waiting[count, 1] = low, at - 1
                    low = at + 1
                count += 1
            insert(a, order, low, high)
        return order

    return argsort


argsort_up, argsort_down = _quicksort(is_less), _quicksort(is_greater)
argsort_floats = _quicksort(is_less_float)
