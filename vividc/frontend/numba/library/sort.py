"""`a.sort()` and `np.sort` of one dimension and `list.sort()`, in place of numba's, which keep a
list.

Heapsort (Williams 1964): no memory of its own, and as many steps for every order of the elements.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.core.cgutils import is_nonelike
from numba.core.typing import signature
from numba.extending import overload_method, register_jitable

from vividc.frontend.numba.library.less import is_less, is_less_float
from vividc.frontend.numba.library.order import argsort_down, argsort_up
from vividc.lang.numba_types import FormatType

_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable
_method: Callable[..., Callable[..., Any]] = functools.partial(overload_method, target="vividc")


def is_sort(operation: object, sig: Any) -> bool:
    """Say whether numba asks for the sort of an array of one dimension."""
    return operation == "array.sort" and sig.recvr is not None and sig.recvr.ndim == 1


def sort(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Sort; NaNs come last, as in numpy."""
    rule = _sort_floats if isinstance(sig.recvr.dtype, types.Float | FormatType) else _sort
    inner = signature(sig.return_type, sig.recvr)
    return context.compile_internal(builder, rule, inner, args[:1])


def _heapsort(is_less: Any) -> Callable[[Any], None]:
    def heapsort(a: Any) -> None:
        start = len(a) // 2
        end = len(a)
        while end > 1:
            if start > 0:  # the heap still grows downwards
                start -= 1
                moved = a[start]
            else:
                end -= 1
                moved = a[end]
                a[end] = a[0]
            hole = start
            child = 2 * start + 1
            while child < end:
                if child + 1 < end and is_less(a[child], a[child + 1]):
                    child += 1
                if not is_less(moved, a[child]):
                    break
                a[hole] = a[child]
                hole = child
                child = 2 * hole + 1
            a[hole] = moved

    return heapsort


_sort, _sort_floats = _heapsort(is_less), _heapsort(is_less_float)


@_method(types.List, "sort")
def _overload_list_sort(lst: Any, key: Any = None, reverse: Any = False) -> Any:
    """In place; with a key, by the order that numba gives what it makes of the elements."""
    if not is_nonelike(key):
        return _sort_by_key
    floats = isinstance(lst.dtype, types.Float)
    rule = _helper(_sort_floats if floats else _sort)

    def sort_list(lst: Any, key: Any = None, reverse: Any = False) -> None:
        rule(lst)
        if reverse:
            lst.reverse()

    return sort_list


def _sort_by_key(lst: Any, key: Any = None, reverse: Any = False) -> None:
    keys = np.array([key(item) for item in lst])
    order = argsort_down(keys) if reverse else argsort_up(keys)
    before = lst.copy()
    for place in range(len(order)):
        lst[place] = before[order[place]]
