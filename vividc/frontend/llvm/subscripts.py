"""Subscripts of accesses, which pass through LLVM as metadata."""

from __future__ import annotations

import re

from vividc.frontend.llvm.metadata import Metadata

KIND = "vividc.subscript"
_MARK = re.compile(rf", !{re.escape(KIND)} (!\d+)")
_ENTRIES = re.compile(r'!"([\d_,]+)"')
VARIABLE = "_"

Subscript = tuple[int | None, ...]
"""One entry for each dimension: its constant, or None."""


class Subscripts:
    """The marks in a module's text."""

    def __init__(self, text: str) -> None:
        self._metadata = Metadata(text)

    def __call__(self, line: str) -> Subscript:
        """Constant subscripts of the access in `line`; () if it has no mark."""
        match = _MARK.search(line)
        text = None if match is None else _ENTRIES.fullmatch(self._metadata.listed(match[1]))
        if text is None:
            return ()
        return tuple(None if part == VARIABLE else int(part) for part in text[1].split(","))
