"""The line of a JSON text on which each node and edge starts, for messages."""

from __future__ import annotations

import json
import re
import sys
from array import array
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Final

from vividc.errors import DFGError

_SPACE: Final = re.compile(r"[ \t\r\n]*")
_ARRAYS: Final = ("nodes", "edges")
_PLACE: Final = re.compile(r"(nodes|edges)\[([0-9]{1,9})\]")
_DECODER: Final = json.JSONDecoder()
_STRING_OR_NUMBER: Final = re.compile(
    r'"[^"\\]*+(?:\\.[^"\\]*+)*+"|-?(?P<digits>\d+)(?P<rest>\.\d+|[eE])?', re.S
)


class ElementLines(Mapping[str, int]):
    """Line, from 1 on, of every element of the arrays "nodes" and "edges" at the top level, as
    "nodes[0]", "nodes[1]", ..., "edges[0]", ...: found when one is asked for.

    Parameters
    ----------
    text
        Valid JSON.
    """

    def __init__(self, text: str) -> None:
        self._text = text

    def __getitem__(self, place: str) -> int:
        match = _PLACE.fullmatch(place)
        offsets = self._offsets.get(match[1]) if match is not None else None
        if match is None or offsets is None or int(match[2]) >= len(offsets):
            raise KeyError(place)
        return self._text.count("\n", 0, offsets[int(match[2])]) + 1

    def __iter__(self) -> Iterator[str]:
        return (f"{key}[{i}]" for key, found in self._offsets.items() for i in range(len(found)))

    def __len__(self) -> int:
        return sum(map(len, self._offsets.values()))

    @cached_property
    def _offsets(self) -> dict[str, array[int]]:
        text = self._text
        offsets: dict[str, array[int]] = {}
        at = _after_space(text, 0)
        if text[at : at + 1] != "{":
            return {}
        at = _after_space(text, at + 1)
        while text[at : at + 1] == '"':
            key, at = _DECODER.raw_decode(text, at)
            at = _after_space(text, _after_space(text, at) + 1)
            if key in _ARRAYS and text[at] == "[":
                offsets[key], at = _elements(text, at)
            else:
                at = _DECODER.raw_decode(text, at)[1]
            at = _after_space(text, _after_space(text, at) + 1)
        return offsets


def too_long_number(text: str, file: str) -> DFGError:
    """What is wrong with a JSON text of which Python refuses an integer: it has too many digits."""
    most = sys.get_int_max_str_digits()
    for match in _STRING_OR_NUMBER.finditer(text):
        digits = match["digits"]
        if digits is not None and match["rest"] is None and len(digits) > most:
            line = text.count("\n", 0, match.start()) + 1
            hint = "a constant is a word of 32 bits; give an id of many characters as a text"
            return DFGError(f"a number of {len(digits)} digits", loc=f"{file}:{line}", hint=hint)
    return DFGError("a number is malformed", loc=file)


def _elements(text: str, at: int) -> tuple[array[int], int]:
    """The offsets of an array's elements, and the offset behind the array."""
    offsets = array("q")
    at = _after_space(text, at + 1)
    while text[at] != "]":
        offsets.append(at)
        at = _after_space(text, _DECODER.raw_decode(text, at)[1])
        if text[at] == ",":
            at = _after_space(text, at + 1)
    return offsets, at + 1


def _after_space(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    return at if match is None else match.end()
