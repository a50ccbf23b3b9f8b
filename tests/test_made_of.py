"""Functions that differ somewhere have other hashes: what is kept for one is not another's."""

from __future__ import annotations

import enum
import sys
from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest

from tests.made_of import made_of


class Colour(enum.Enum):
    RED = 1


class Pair(NamedTuple):
    a: int
    b: int


def returning(value: Any) -> Callable[[], Any]:
    def read() -> Any:
        return value

    return read


def calling(function: Callable[..., Any]) -> Callable[[], Any]:
    def call() -> Any:
        return function()

    return call


def written(text: str, **names: object) -> FunctionType:
    """A function `f` over globals of other files."""
    space: dict[str, Any] = {"__name__": "somewhere", **names}
    exec(text, space)
    return space["f"]  # type: ignore[no-any-return]


class Reversed(NamedTuple):
    b: int
    a: int


Reversed.__qualname__ = "Pair"
READ = "def f(): return A"
DIFFERENT = [
    (returning(1), returning(2)),
    (returning(1), returning(1.0)),
    (returning(1), returning(np.int64(1))),
    (returning(0.0), returning(-0.0)),
    (returning((1, 2)), returning((2, 1))),
    (returning(Pair), returning(Reversed)),
    (returning(np.array([1, 2])), returning(np.array([1, 3]))),
    (returning(np.arange(2000)), returning(np.arange(2000)[::-1])),
    (returning(np.zeros((2, 3))), returning(np.zeros((3, 2)))),
    (returning(np.zeros((2, 3))), returning(np.asfortranarray(np.zeros((2, 3))))),
    (calling(returning(1)), calling(returning(2))),
    (calling(calling(returning(1))), calling(calling(returning(2)))),
    (written(READ, A=1), written(READ, A=2)),
    (written("def f(): return 1"), written("def f(): return 2")),
    (written("def f(): return 1"), written("def f(): return True")),
    (written("def f(x): return x + 1"), written("def f(x): return x - 1")),
    (written("def f(x=1): return x"), written("def f(x=2): return x")),
    (written("def f(*, x=1): return x"), written("def f(*, x=2): return x")),
    (
        written("def f(x=A): return x", A=np.arange(2000)),
        written("def f(x=A): return x", A=np.arange(2000) // 1000 * 1000),
    ),
    (
        written("def f(): return FS[0]()", FS=(returning(1),)),
        written("def f(): return FS[0]()", FS=(returning(2),)),
    ),
    (written("def f(x, y): return x"), written("def f(y, x): return x")),
    (written("def f(): return min(1, 2)"), written("def f(): return max(1, 2)")),
    (
        written("def f(): return g()", g=returning(1)),
        written("def f(): return g()", g=returning(2)),
    ),
    (
        written("def f(): return [A for _ in ()]", A=1),
        written("def f(): return [A for _ in ()]", A=2),
    ),
    (
        written("def f(): return C.RED.value", C=Colour),
        written("def f(): return C.RED.value", C=enum.Enum("Colour", {"RED": 2})),
    ),
]


@pytest.mark.parametrize(("one", "other"), DIFFERENT)
def test_functions_that_differ_somewhere_are_told_apart(
    one: FunctionType, other: FunctionType
) -> None:
    assert made_of(one) == made_of(one)
    assert made_of(one) != made_of(other)


def test_a_constant_of_a_module_counts() -> None:
    other = type(sys)("other")
    function = written("def f(): return other.A", other=other)
    hashes = set()
    for value in (1, 2):
        other.A = value  # type: ignore[attr-defined]
        hashes.add(made_of(function))
    assert len(hashes) == 2


def test_a_constant_of_a_module_in_a_module_counts() -> None:
    outer, inner = type(sys)("outer"), type(sys)("inner")
    outer.inner, inner.outer = inner, outer  # type: ignore[attr-defined]
    function = written("def f(): return outer.inner.A", outer=outer)
    hashes = set()
    for value in (1, 2):
        inner.A = value  # type: ignore[attr-defined]
        hashes.add(made_of(function))
    assert len(hashes) == 2


def test_functions_that_call_each_other_have_a_hash() -> None:
    space: dict[str, Any] = {"__name__": "somewhere"}
    exec("def f(n): return g(n)\ndef g(n): return f(n)", space)
    assert made_of(space["f"]) != made_of(space["g"])
