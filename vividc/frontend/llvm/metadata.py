"""A module's metadata, and the source lines that it gives instructions."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from vividc.errors import SourceLoc

_NODE = re.compile(r"^(!\d+) = (?:distinct )?(!\w*)[({](.*)[)}]$", re.MULTILINE)
_FIELD = re.compile(r'(\w+): (?:"((?:[^"\\]|\\.)*)"|([^,]+))')
_LINE = re.compile(r"[1-9][0-9]{0,9}")
_DBG = re.compile(r"!dbg (!\d+)")
_MADE = "__numba_"


class Metadata:
    """The numbered nodes of a module. LLVM does not check where nodes point: one may lead nowhere,
    or in a circle.
    """

    def __init__(self, text: str) -> None:
        self._nodes = {match[1]: (match[2], match[3]) for match in _NODE.finditer(text)}
        self._fields: dict[str, dict[str, str]] = {}

    def of_kind(self, kind: str) -> Iterator[str]:
        """Nodes such as `!DILocalVariable(...)`."""
        return (node for node, (given, _) in self._nodes.items() if given == kind)

    def listed(self, node: str) -> str:
        """What stands between the braces of a list; "" if there is no such node."""
        kind, text = self._nodes.get(node, ("", ""))
        return text if kind == "!" else ""

    def fields(self, node: str) -> dict[str, str]:
        """The fields of a node by name, without quotes; none if there is no such node."""
        if node not in self._fields:
            _, text = self._nodes.get(node, ("", ""))
            self._fields[node] = {m[1]: m[2] or m[3] or "" for m in _FIELD.finditer(text)}
        return self._fields[node]

    def path(self, node: str, way: str) -> Iterator[dict[str, str]]:
        """The fields of a node, and of those that it leads to by the field `way`."""
        seen: set[str] = set()
        while node in self._nodes and node not in seen:
            seen.add(node)
            yield self.fields(node)
            node = self.fields(node).get(way, "")


def debug_node(line: str) -> str:
    """The node that a line is attached to by `!dbg`; "" without."""
    match = _DBG.search(line)
    return "" if match is None else match[1]


class Locations:
    """Source lines of `!dbg` attachments.

    Of a chain of inlined calls the innermost line in the user's own file counts: a fault inside a
    helper or inside numba is reported where the kernel asked for it.
    """

    def __init__(self, text: str, file: str) -> None:
        self._file = file
        self._metadata = Metadata(text)

    def __call__(self, line: str) -> SourceLoc | None:
        chain = list(self._chain(debug_node(line)))
        own = [loc for loc in chain if loc.file == self._file]
        return own[0] if own else next(iter(chain), None)

    def definition(self, header: str) -> SourceLoc | None:
        """Where the function of a `define` line is defined."""
        node = debug_node(header)
        return self._place(node, self._metadata.fields(node))

    def _chain(self, node: str) -> Iterator[SourceLoc]:
        for fields in self._metadata.path(node, "inlinedAt"):
            scope = fields.get("scope", "")
            place = self._place(scope, fields)
            # A function that numba makes of an array expression has the kernel's file, and lines
            # of its own.
            name = self._metadata.fields(scope).get("name", "")
            if place is not None and not name.startswith(_MADE):
                yield place

    def _place(self, scope: str, fields: dict[str, str]) -> SourceLoc | None:
        line, file = fields.get("line", ""), self._file_of(scope)
        if file is None or not _LINE.fullmatch(line):  # line 0 is LLVM's mark of merged code
            return None
        return SourceLoc(file, int(line))

    def _file_of(self, scope: str) -> str | None:
        scopes = self._metadata.path(scope, "scope")
        file = self._metadata.fields(next((s["file"] for s in scopes if "file" in s), ""))
        if "filename" not in file:
            return None
        name = re.sub(r"\\([0-9A-Fa-f]{2})", lambda m: chr(int(m[1], 16)), file["filename"])
        directory = file.get("directory", "")
        inside = not directory or name.startswith(("/", directory))
        return os.path.abspath(name if inside else f"{directory}/{name}")
