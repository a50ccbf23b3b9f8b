"""Subscripts of accesses, as they pass LLVM in a type's metadata."""

from __future__ import annotations

import re

_KIND = "vividc.subscript"


_VARIABLE = "_"


_MARK = re.compile(rf", !{re.escape(_KIND)} (!\d+)")


_NODE = re.compile(r'^(!\d+) = !\{!"([\d_,]+)"\}$', re.MULTILINE)


Subscript = tuple[int | None, ...]
"""One entry for each dimension: its constant, or None."""


class Subscripts:
    """The marks in a module's text."""

    def __init__(self, text: str) -> None:
        self._nodes = {match[1]: match[2] for match in _NODE.finditer(text)}

    def __call__(self, line: str) -> Subscript:
        """Constant subscripts of the access in `line`; () if it has no mark."""
        match = _MARK.search(line)
        text = None if match is None else self._nodes.get(match[1])
        if text is None:
            return ()
        return tuple(None if part == _VARIABLE else int(part) for part in text.split(","))
