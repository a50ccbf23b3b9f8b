"""Constant arrays in a module's text: `@name = ... constant [4 x i32] [i32 1, ...]`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from vividc.errors import InternalError, KernelError, SourceLoc, warn
from vividc.frontend.advice import Advice
from vividc.frontend.llvm.tokens import Cursor, bare, unescaped
from vividc.frontend.ranges.interval import S32, U32
from vividc.machine.words import WORD_MASK
from vividc.ssa.ir import Float, Int

_GLOBAL = re.compile(r'^(@(?:"(?:[^"\\]|\\.)*"|[-\w.$]+)) = .*?\bconstant (\[.*)$', re.MULTILINE)
_ARRAY = re.compile(r"\[(\d+)x(.*)\]")
_SCALARS = frozenset({"i8", "i16", "i32", "i64", "float", "double"})
_MAX_LENGTH = 1 << 24
_UNDEFINED = frozenset({"zeroinitializer", "poison", "undef"})

PACKED_BYTES = {"i8": 1, "i16": 2}

Number = int | float


@dataclass(frozen=True, slots=True)
class Table:
    """A constant array, flattened in C order: LLVM type of the elements, and their values."""

    element: str
    values: tuple[Number, ...]


def tables_of(text: str) -> dict[str, Table]:
    """Constant arrays of numbers by name; nested arrays are flattened, others are left out."""
    tables: dict[str, Table] = {}
    for match in _GLOBAL.finditer(text):
        cursor = Cursor(match[2])
        type_ = cursor.type()
        element = _scalar_of(type_)
        if _length(type_) > _MAX_LENGTH:
            reason = f"a constant array of {_length(type_)} elements"
            raise KernelError(reason, hint="pass it as a parameter")
        if element in _SCALARS and cursor.peek not in ("", ","):  # else another file has it
            values = _values(cursor, type_)
            if None not in values:
                tables[bare(match[1])] = Table(element, tuple(v for v in values if v is not None))
    return tables


def words_of(table: Table, loc: SourceLoc | None) -> tuple[int, ...]:
    """The table's elements as words.

    Raises
    ------
    KernelError
        An element has no word of the same value, or of float64 none near it.

    Warns
    -----
    VividcWarning
        Elements of float64 are rounded.
    """
    if table.element in ("float", "double"):
        words = tuple(_float_word(float(value), table, loc) for value in table.values)
        if table.element == "double":
            _tell_rounded(np.array(table.values), loc)
        return words
    if table.element == "i64" and not any(
        all(low <= value <= high for value in table.values) for low, high in (S32, U32)
    ):
        raise KernelError(
            "a constant array of int64 holds integers that do not fit in 32 bits",
            loc=loc,
            hint=Advice(
                "keep its numbers within int32, or within uint32",
                c="keep its numbers within int32_t, or within uint32_t",
            ),
        )
    return tuple(int(value) & WORD_MASK for value in table.values)


def packed_words_of(table: Table) -> tuple[int, ...]:
    """A table of bytes or halves as C's memory has it, four or two in a word."""
    size = PACKED_BYTES[table.element]
    mask = (1 << 8 * size) - 1
    raw = b"".join((int(value) & mask).to_bytes(size, "little") for value in table.values)
    raw += bytes(-len(raw) % 4)
    return tuple(int.from_bytes(raw[at : at + 4], "little") for at in range(0, len(raw), 4))


def _float_word(value: float, table: Table, loc: SourceLoc | None) -> int:
    """Elements of float64 are rounded, as those of the kernel's own arrays are."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        narrow = np.float32(value)
    lost = math.isinf(narrow) or (not narrow and value)
    if table.element == "double" and lost and math.isfinite(value):
        raise KernelError(
            f"a constant array of float64 holds {value!r}, which float32 cannot hold",
            loc=loc,
            hint=Advice(
                "keep its numbers within float32, or scale them",
                c="make it an array of float",
            ),
        )
    return int(narrow.view(np.uint32))


def _tell_rounded(values: np.ndarray, loc: SourceLoc | None) -> None:
    with np.errstate(under="ignore"):
        rounded = values.astype(np.float32)
    if not np.array_equal(rounded, values, equal_nan=True):
        place = "" if loc is None else f"{loc}: "
        instead = "make it of float32, np.array([...], np.float32), to round it yourself"
        warn(f"{place}a constant array of float64 is rounded to float32; {instead}")


def _scalar_of(type_: str) -> str:
    match = _ARRAY.fullmatch(type_)
    return type_ if match is None else _scalar_of(match[2])


def _length(type_: str) -> int:
    match = _ARRAY.fullmatch(type_)
    return 1 if match is None else int(match[1]) * _length(match[2])


def _values(cursor: Cursor, type_: str) -> list[Number | None]:
    """The numbers of a constant; None for an address."""
    match = _ARRAY.fullmatch(type_)
    if match is None:
        operand = cursor.operand(type_)
        return [operand.value if isinstance(operand, Int | Float) else None]
    if cursor.peek in _UNDEFINED:
        cursor.take()
        return [0] * _length(type_)
    if cursor.peek.startswith('c"'):
        return _checked(list(unescaped(cursor.take()[2:-1])), type_)
    values: list[Number | None] = []
    cursor.expect("[")
    while not cursor.accept("]"):
        values += _values(cursor, cursor.type())
        cursor.accept(",")
    return _checked(values, type_)


def _checked(values: list[Number | None], type_: str) -> list[Number | None]:
    """A reader that lost its place must not give a table of other values."""
    if len(values) != _length(type_):
        raise InternalError(f"read {len(values)} constants of {type_}")
    return values
