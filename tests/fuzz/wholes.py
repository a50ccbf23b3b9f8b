"""Random expressions of whole arrays and slices, with the type and the range of their elements: no
sum or product of 64 bits overflows, and what is narrower wraps as in numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tests.fuzz.integers import Context
from tests.fuzz.places import Array
from tests.fuzz.values import TYPES
from tests.fuzz.views import View, fitting

INTEGERS = tuple(TYPES)
TESTS = ("<", "<=", ">", ">=", "==", "!=")
REALS = (
    "({a} + {b})",
    "({a} - {b})",
    "({a} * {b})",
    "({a} * np.float32(0.5))",
    "({a} / np.float32(4.0))",
    "np.minimum({a}, {b})",
    "np.maximum({a}, {b})",
    "np.abs({a})",
    "(-{a})",
    "np.sqrt(np.abs({a}))",
    "np.floor({a})",
    "np.where({cond}, {a}, {b})",
)


class Arrays(Context, Protocol):
    """What an expression of arrays may read."""

    arrays: list[Array]
    inexact: set[str]

    def scalar(self) -> str:
        """A signed expression without arrays' methods."""


@dataclass(frozen=True, slots=True)
class Elements:
    """An expression, the type of its elements, and the least and the greatest of them."""

    text: str
    dtype: str
    low: int
    high: int
    is_array: bool = True

    @property
    def size(self) -> int:
        """The greatest magnitude."""
        return max(abs(self.low), abs(self.high))


def _made(text: str, dtype: str, low: int, high: int) -> Elements | None:
    """None: it may overflow 64 bits. What is narrower wraps."""
    least, most = TYPES[dtype]
    if least <= low and high <= most:
        return Elements(text, dtype, low, high)
    return None if dtype == "int64" else Elements(text, dtype, least, most)


def literal(number: int) -> Elements:
    """A number, which numba takes for 64 bits."""
    return Elements(str(number) if number >= 0 else f"({number})", "int64", number, number, False)


def operand(at: Arrays, dims: tuple[str, ...], dtypes: tuple[str, ...]) -> View | None:
    """Part of an array that fits."""
    found = []
    for array in at.arrays:
        if array.dtype in dtypes and array.name not in at.inexact:
            view = fitting(at.random, array, dims)
            found += [view] if view is not None else []
    if not found:
        return None
    view = at.random.choice(found)
    return view


def whole_integers(at: Arrays, dims: tuple[str, ...], depth: int) -> Elements:
    """An expression of integers of these dimensions, or of fewer."""
    if depth == 0:
        return _leaf(at, dims)
    a, b = whole_integers(at, dims, depth - 1), whole_integers(at, dims, 0)
    if not a.is_array:
        a, b = b, a
    if not a.is_array:
        return a
    return at.random.choice(FORMS)(at, dims, a, b) or a


def _leaf(at: Arrays, dims: tuple[str, ...]) -> Elements:
    view = operand(at, dims, INTEGERS) if at.random.random() < 0.85 else None
    if view is None:
        return _number(at)
    dtype = view.array.dtype
    low, high = (-(2**20), 2**20) if dtype == "int64" else TYPES[dtype]
    return Elements(view.text, dtype, low, high)


def _number(at: Arrays) -> Elements:
    if at.random.random() < 0.5:
        return literal(at.random.choice([0, 1, 2, 3, 7, 255, -1, -5, 1000]))
    return Elements(f"np.int32({at.scalar()})", "int32", *TYPES["int32"], False)


def _common(a: Elements, b: Elements) -> str:
    return np.result_type(np.dtype(a.dtype), np.dtype(b.dtype)).name


def _ring(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    dtype, operator = _common(a, b), at.random.choice(["+", "-", "*", "&", "|", "^"])
    a, b = at.random.choice([(a, b), (a, b), (b, a)])
    text = f"({a.text} {operator} {b.text})"
    if operator == "+":
        return _made(text, dtype, a.low + b.low, a.high + b.high)
    if operator == "-":
        return _made(text, dtype, a.low - b.high, a.high - b.low)
    if operator == "*":
        ends = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
        return _made(text, dtype, min(ends), max(ends))
    bits = max(value.bit_length() for value in (a.low, a.high, b.low, b.high))
    return _made(text, dtype, -(2**bits) if min(a.low, b.low) < 0 else 0, 2**bits - 1)


def _divide(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    if at.random.random() < 0.6:
        divisor = literal(at.random.choice([1, 2, 3, 7, 16, 255, -3, -8]))
    else:
        divisor = Elements(f"(({b.text} & 7) + 1)", "int64", 1, 8)
    operator = at.random.choice(["//", "%"])
    size = a.size if operator == "//" else divisor.size
    return _made(f"({a.text} {operator} {divisor.text})", "int64", -size, size)


def _shift(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    amount = at.random.choice([0, 1, 5, 8, 15])
    if at.random.random() < 0.5:
        return _made(f"({a.text} >> {amount})", "int64", a.low >> amount, a.high >> amount)
    return _made(f"({a.text} << {amount})", "int64", a.low << amount, a.high << amount)


def _extreme(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    name = at.random.choice(["minimum", "maximum"])
    text, dtype = f"np.{name}({a.text}, {b.text})", _common(a, b)
    return _made(text, dtype, min(a.low, b.low), max(a.high, b.high))


def _unary(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    kind = at.random.random()
    if kind < 0.4:
        return _made(f"(~{a.text})", a.dtype, *TYPES[a.dtype])
    if a.dtype.startswith("u"):
        return None
    text = f"np.abs({a.text})" if kind < 0.7 else f"(-{a.text})"
    return _made(text, a.dtype, -a.size, a.size)


def _power(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    return Elements(f"(({a.text} & 31) ** {at.random.choice([2, 3])})", "int64", 0, 31**3)


def _mask(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    mask = at.random.choice([1, 15, 255, 65535])
    return Elements(f"({a.text} & {mask})", "int64", 0, mask)


def _cast(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    view = operand(at, dims, INTEGERS)
    if view is None or ("[" in view.text and at.random.random() < 0.5):
        return None
    dtype = at.random.choice(["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64"])
    return Elements(f"{view.text}.astype(np.{dtype})", dtype, *TYPES[dtype])


def _where(at: Arrays, dims: tuple[str, ...], a: Elements, b: Elements) -> Elements | None:
    condition = whole_condition(at, dims)
    if condition is None:
        return None
    text = f"np.where({condition}, {a.text}, {b.text})"
    return _made(text, _common(a, b), min(a.low, b.low), max(a.high, b.high))


Form = Callable[[Arrays, tuple[str, ...], Elements, Elements], Elements | None]
FORMS: tuple[Form, ...] = (
    _ring, _ring, _ring, _ring, _divide, _shift, _extreme, _unary, _power, _mask, _cast, _where,
)  # fmt: skip


def whole_condition(at: Arrays, dims: tuple[str, ...]) -> str | None:
    """An array of flags of all of these dimensions; None if there is nothing to ask."""
    view = _full(at, dims, (*INTEGERS, "float32", "boolean"))
    if view is None:
        return None
    if view.array.dtype == "boolean":
        form = at.random.choice(["{a}", "(~{a})", "np.logical_not({a})"])
        return form.format(a=view.text)
    test = at.random.choice(TESTS)
    if view.array.dtype == "float32":
        return f"({view.text} {test} {whole_reals(at, dims, 0)})"
    return f"({view.text} {test} {_leaf(at, dims).text})"


def _full(at: Arrays, dims: tuple[str, ...], dtypes: tuple[str, ...]) -> View | None:
    """Part of an array that has all of these dimensions, without broadcasting."""
    for _ in range(4):
        view = operand(at, dims, dtypes)
        if view is not None and len(view.array.dims) == len(dims) and ":1" not in view.text:
            return view
    return None


def whole_reals(at: Arrays, dims: tuple[str, ...], depth: int) -> str:
    """An expression of float32 whose bits are the same on every machine."""
    if depth == 0:
        return _real_leaf(at, dims)
    a, b = whole_reals(at, dims, depth - 1), whole_reals(at, dims, 0)
    form, condition = at.random.choice(REALS), None
    if "cond" in form:
        condition = whole_condition(at, dims)
        form = form if condition else "({a} + {b})"
    return form.format(a=a, b=b, cond=condition)


def _real_leaf(at: Arrays, dims: tuple[str, ...]) -> str:
    view = operand(at, dims, ("float32",)) if at.random.random() < 0.8 else None
    if view is not None:
        return view.text
    view = operand(at, dims, ("int16", "uint8", "int32")) if at.random.random() < 0.4 else None
    if view is not None and view.text.isidentifier():
        return f"{view.text}.astype(np.float32)"
    return at.random.choice(["z", "w", "np.float32(1.25)", "np.float32(-3.0)"])
