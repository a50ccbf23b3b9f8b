"""What a kernel may not do: the error names the line and a way out."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from vividc.errors import KernelError, SourceLoc
from vividc.frontend import KernelFunction


def float_remainder(x, n):
    for i in range(n):
        x[i] = math.fmod(x[0], x[i])


def log_gamma(x, n):
    for i in range(n):
        x[i] = math.lgamma(x[i])


def prints(x, n):
    for i in range(n):
        print(x[i])


def catches(x, n):
    try:
        x[0] = n
    except Exception:
        x[1] = n


def unknown_attribute(x, n):
    x.frobnicate(n)


def never_ends(x, n):
    while True:
        x[0] += 1


def recurses(x, n):
    def inner(k):
        return k if k < 2 else inner(k - 1)

    x[0] = inner(n)


FLOAT_KERNELS: list[tuple[Callable[..., object], int, str]] = [
    (float_remainder, 2, "a float remainder|fmod"),
    (log_gamma, 2, "lgamma"),
    (prints, 2, "`print`"),
    (catches, 1, "`try`"),
    (unknown_attribute, 1, "frobnicate"),
    (never_ends, 1, "never ends"),
    (recurses, 2, "recursi"),
]


def _short(value: object) -> str:
    return getattr(value, "__name__", str(value)[:30])


@pytest.mark.parametrize(("function", "offset", "reason"), FLOAT_KERNELS, ids=_short)
def test_the_error_names_the_line(
    function: Callable[..., object], offset: int, reason: str
) -> None:
    kernel = KernelFunction(function, "void(float32[::1], int32)", None)
    with pytest.raises(KernelError, match=reason) as caught:
        kernel.lower()
    assert isinstance(caught.value.loc, SourceLoc)
    assert caught.value.loc.file == __file__
    assert caught.value.loc.line == function.__code__.co_firstlineno + offset


def test_strict_fp_refuses_float64_arithmetic() -> None:
    def scale(x, n):
        for i in range(n):
            x[i] = x[i] * 0.1

    kernel = KernelFunction(scale, "void(float32[::1], int32)", None)
    with pytest.raises(KernelError, match="float64 arithmetic") as caught:
        kernel.lower(strict_fp=True)
    assert caught.value.loc == SourceLoc(__file__, scale.__code__.co_firstlineno + 2)
