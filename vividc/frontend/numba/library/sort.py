"""`a.sort()` and `np.sort` of one dimension in place of numba's, which keeps a list.

Heapsort (Williams 1964): no memory of its own, and as many steps for every order of the elements.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.core.typing import signature
from numba.extending import register_jitable

from vividc.lang.numba_types import FormatType

_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


def is_sort(operation: object, sig: Any) -> bool:
    """Say whether numba asks for the sort of an array of one dimension."""
    return operation == "array.sort" and sig.recvr is not None and sig.recvr.ndim == 1


def sort(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Sort; NaNs come last, as in numpy."""
    rule = _sort_floats if isinstance(sig.recvr.dtype, types.Float | FormatType) else _sort
    inner = signature(sig.return_type, sig.recvr)
    return context.compile_internal(builder, rule, inner, args[:1])


@_helper
def _is_less(a: Any, b: Any) -> Any:
    return a < b


@_helper
def _is_less_float(a: Any, b: Any) -> Any:
    return a < b or (b != b and a == a)  # noqa: PLR0124 - a NaN is no number's equal


def _heapsort(is_less: Any) -> Callable[[Any], None]:
    def heapsort(a: Any) -> None:
        start = a.shape[0] // 2
        end = a.shape[0]
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


_sort, _sort_floats = _heapsort(_is_less), _heapsort(_is_less_float)
