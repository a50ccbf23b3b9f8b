"""On which line of a JSON text each node and edge stands, for messages."""

from __future__ import annotations

import json
import re
import sys
from bisect import bisect_right
from typing import Final

from vividc.errors import DFGError

_SPACE: Final = re.compile(r"[ \t\r\n]*")
_ARRAYS: Final = ("nodes", "edges")
_DECODER: Final = json.JSONDecoder()
_STRING_OR_NUMBER: Final = re.compile(
    r'"(?:[^"\\]|\\.)*"|-?(?P<digits>\d+)(?P<rest>\.\d+|[eE])?', re.S
)


def element_lines(text: str) -> dict[str, int]:
    """Line, from 1 on, of every element of the arrays "nodes" and "edges" at the top level.

    Parameters
    ----------
    text
        Valid JSON.

    Returns
    -------
    dict
        Line of "nodes[0]", "nodes[1]", ..., "edges[0]", ...
    """
    breaks = [match.start() for match in re.finditer("\n", text)]
    offsets: dict[str, int] = {}
    at = _after_space(text, 0)
    if text[at : at + 1] != "{":
        return {}
    at = _after_space(text, at + 1)
    while text[at : at + 1] == '"':
        key, at = _DECODER.raw_decode(text, at)
        at = _after_space(text, _after_space(text, at) + 1)
        if key in _ARRAYS and text[at] == "[":
            at = _elements(text, at, key, offsets)
        else:
            at = _DECODER.raw_decode(text, at)[1]
        at = _after_space(text, _after_space(text, at) + 1)
    return {place: bisect_right(breaks, offset) + 1 for place, offset in offsets.items()}


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


def _elements(text: str, at: int, key: str, offsets: dict[str, int]) -> int:
    """Enter the offsets of an array's elements; the offset behind the array."""
    at = _after_space(text, at + 1)
    index = 0
    while text[at] != "]":
        offsets[f"{key}[{index}]"] = at
        index += 1
        at = _after_space(text, _DECODER.raw_decode(text, at)[1])
        if text[at] == ",":
            at = _after_space(text, at + 1)
    return at + 1


def _after_space(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    return at if match is None else match.end()
