"""The orders of elements that sorts keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import register_jitable

_helper: Callable[[Callable[..., Any]], Callable[..., Any]] = register_jitable


@_helper
def is_less(a: Any, b: Any) -> Any:
    return a < b


@_helper
def is_less_float(a: Any, b: Any) -> Any:
    return a < b or (b != b and a == a)  # noqa: PLR0124 - a NaN is no number's equal


@_helper
def is_greater(a: Any, b: Any) -> Any:
    return a > b
