"""What values compiled functions work on, as their annotations say."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Annotated, Any, Final, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np


@dataclass(frozen=True, slots=True)
class Number:
    """A number; `llvm`: its type there."""

    llvm: str


@dataclass(frozen=True, slots=True)
class Array:
    """A C-contiguous array of so many dimensions; `dtype`: numpy's name of its elements."""

    dtype: str
    rank: int = 1

    @property
    def numpy(self) -> np.dtype[Any]:
        """The type of its elements."""
        return _NUMPY[self.dtype]


@dataclass(frozen=True, slots=True)
class Record:
    """A tuple, with names if it is a named one. With an array in it it is passed as the address of
    its words, which nothing changes; without, part by part.
    """

    names: tuple[str, ...]
    fields: tuple[Type, ...]
    cls: type | None = None

    @property
    def is_stored(self) -> bool:
        """Whether it is passed by its address."""
        return any(
            isinstance(f, Array) or (isinstance(f, Record) and f.is_stored) for f in self.fields
        )


Type: TypeAlias = Number | Array | Record

INT: Final = Number("i64")
FLOAT: Final = Number("double")
SINGLE: Final = Number("float")
TRUTH: Final = Number("i1")
NOTHING: Final = Record((), ())

_NUMBERS: Final[dict[Any, Number]] = {int: INT, float: FLOAT, bool: TRUTH}
ELEMENTS: Final[dict[str, tuple[str, Number]]] = {
    "int64": ("i64", INT),
    "float64": ("double", FLOAT),
    "float32": ("float", SINGLE),
    "uint8": ("i8", INT),
}
"""By numpy's name: what is in memory, and what it is as a value."""
_NUMPY: Final = {name: np.dtype(name) for name in ELEMENTS}


def type_of(annotation: Any) -> Type:
    """The type that an annotation means.

    Raises
    ------
    TypeError
        It means none of these.
    """
    if annotation in _NUMBERS:
        return _NUMBERS[annotation]
    if annotation is type(None):
        return NOTHING
    origin = get_origin(annotation)
    if origin is Annotated:
        base, rank = get_args(annotation)[:2]
        return _array(base, rank)
    if origin is np.ndarray:
        return _array(annotation, 1)
    if origin is tuple:
        fields = tuple(map(type_of, get_args(annotation)))
        return Record(("",) * len(fields), fields)
    if isinstance(annotation, type) and hasattr(annotation, "_fields"):
        return _record(annotation)
    raise TypeError(f"no type of compiled functions: {annotation!r}")


def _array(annotation: Any, rank: int) -> Array:
    dtype = np.dtype(get_args(get_args(annotation)[1])[0]).name
    if dtype not in ELEMENTS:
        raise TypeError(f"no elements of compiled functions: {dtype}")
    return Array(dtype, rank)


@functools.cache
def _record(cls: type) -> Record:
    hints = get_type_hints(cls, include_extras=True)
    names: tuple[str, ...] = cls._fields  # type: ignore[attr-defined]
    return Record(names, tuple(type_of(hints[name]) for name in names), cls)


def words(kind: Type) -> int:
    """How many words it takes in memory."""
    if isinstance(kind, Number):
        return 1
    if isinstance(kind, Array):
        return 1 + kind.rank
    return sum(map(words, kind.fields))


def parts(kind: Type) -> tuple[str, ...]:
    """The LLVM types in which it is passed: of an array its address and its lengths."""
    if isinstance(kind, Number):
        return (kind.llvm,)
    if isinstance(kind, Array):
        return ("ptr", *("i64",) * kind.rank)
    if kind.is_stored:
        return ("ptr",)
    return tuple(part for field in kind.fields for part in parts(field))
