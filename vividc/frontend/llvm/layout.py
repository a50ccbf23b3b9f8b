"""Byte offsets of LLVM's `getelementptr`: strides of arrays, offsets of structure members."""

from __future__ import annotations

import re
from collections.abc import Iterator

from vividc.errors import KernelError
from vividc.frontend.llvm.tokens import Cursor, Structs
from vividc.ssa.ir import Int, Value

_BYTES = {"i1": 1, "i8": 1, "i16": 2, "i32": 4, "float": 4, "ptr": 4, "i64": 8, "double": 8}
_STRUCT = re.compile(r'^(%(?:"[^"]*"|\S+)) = type (\{.*\})$', re.MULTILINE)
_MAX_DEPTH = 100
_ARRAY = re.compile(r"\[(\d+)x(.*)\]")


def structs_of(text: str) -> Structs:
    """The named structures of a module's text."""
    return Structs({match[1]: Cursor(match[2]).type() for match in _STRUCT.finditer(text)})


def offsets(
    element: str, indices: tuple[Value, ...], structs: Structs
) -> tuple[tuple[Value, ...], tuple[int, ...]] | None:
    """Indices and the bytes per unit of each; a member's index becomes its offset.

    None if an element's size is not known.
    """
    scaled: list[tuple[Value, int]] = []
    for position, index in enumerate(indices):
        inside = list(members(element, structs)) if position else []
        if inside:
            assert isinstance(index, Int)  # LLVM takes nothing else
            scaled.append((Int(_offset(inside, index.value, structs)), 1))
            element = inside[index.value]
            continue
        inner = _ARRAY.fullmatch(element) if position else None
        element = inner[2] if inner is not None else element
        layout = _layout(element, structs)
        if layout is None or (position and inner is None):
            return None
        scaled.append((index, layout[0]))
    return tuple(index for index, _ in scaled), tuple(stride for _, stride in scaled)


def part_type(type_: str, indices: tuple[int, ...], structs: Structs) -> str:
    """The type of what lies in an aggregate at constant indices."""
    for index in indices:
        array = _ARRAY.fullmatch(type_)
        type_ = array[2] if array is not None else list(members(type_, structs))[index]
    return type_


def size_of(type_: str, structs: Structs) -> int | None:
    """Bytes of a value; None if its type is not known.

    Raises
    ------
    KernelError
        Types lie in types more than 100 deep.
    """
    layout = _layout(type_, structs)
    return None if layout is None else layout[0]


def _layout(type_: str, structs: Structs, depth: int = 0) -> tuple[int, int] | None:
    """Size and alignment in bytes."""
    if depth > _MAX_DEPTH:
        raise KernelError(
            f"types nested more than {_MAX_DEPTH} deep", hint="flatten the structures"
        )
    if type_ not in structs.layouts:
        structs.layouts[type_] = _computed_layout(type_, structs, depth)
    return structs.layouts[type_]


def _computed_layout(type_: str, structs: Structs, depth: int) -> tuple[int, int] | None:
    if type_ in _BYTES:
        return _BYTES[type_], _BYTES[type_]
    array = _ARRAY.fullmatch(type_)
    if array is not None:
        inner = _layout(array[2], structs, depth + 1)
        return None if inner is None else (int(array[1]) * inner[0], inner[1])
    inside = list(members(type_, structs))
    layouts = [_layout(member, structs, depth + 1) for member in inside]
    if not inside or None in layouts:
        return None
    align = max(layout[1] for layout in layouts if layout is not None)
    return _aligned(_offset(inside, len(inside), structs), align), align


def _offset(inside: list[str], count: int, structs: Structs) -> int:
    """Where member `count` starts, or the end of all."""
    at = 0
    for position, member in enumerate(inside[: count + 1]):
        size, align = _layout(member, structs) or (0, 1)
        at = _aligned(at, align)
        if position == count:
            return at
        at += size
    return at


def _aligned(offset: int, align: int) -> int:
    return -(-offset // align) * align


def members(type_: str, structs: Structs) -> Iterator[str]:
    """Types of a structure's members; none of any other type."""
    text = structs.get(type_, type_)
    if not text.startswith("{"):
        return
    depth, member = 0, ""
    for letter in text[1:-1] + ",":
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and not depth:
            yield member
            member = ""
        else:
            member += letter
