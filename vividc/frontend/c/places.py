"""The lines on which a `.ll` file's instructions start, however the file breaks them.

LLVM's language knows no lines. Where an instruction starts is seen from its tokens: `%name =`, or
the word of one that has no result.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from vividc.frontend.llvm.tokens import bare

_TOKEN = re.compile(
    r'(?P<line>\n)|;[^\n]*|(?P<label>^\s*(?:"[^"]*"|[-\w.$]+):)|(?P<name>[%@](?:"[^"]*"|[-\w.$]+))'
    r'|c?"[^"]*"|(?P<word>[#!]?[A-Za-z_][\w.]*)|(?P<mark>[][(){}=])',
    re.MULTILINE,
)
_WITHOUT_RESULT = frozenset(
    [
        "store",
        "br",
        "ret",
        "switch",
        "unreachable",
        "fence",
        "resume",
        "indirectbr",
        "cleanupret",
        "catchret",
        "call",
        "tail",
        "musttail",
        "notail",
        "invoke",
        "callbr",
    ]
)
_BEFORE_CALL = ("=", "tail", "musttail", "notail")
_OPEN, _CLOSE = frozenset("([{"), frozenset(")]}")


def instruction_lines(text: str) -> dict[str, tuple[int, ...]]:
    """For each function that a file defines: its line, then the line of each instruction in order.

    Calls of `llvm.dbg` functions are not counted. Of instructions whose result has no name in the
    file some may be missing.
    """
    lines: dict[str, tuple[int, ...]] = {}
    tokens = _tokens(text)
    for token, line in tokens:
        if token == "define":
            name = _header(tokens)
            lines[name] = (line, *_body(tokens))
    return lines


def nesting(text: str) -> tuple[int, int]:
    """The greatest depth of brackets within brackets, and the line where it is reached."""
    depth, deepest, where = 0, 0, 1
    for token, line in _tokens(text):
        depth += (token in _OPEN) - (token in _CLOSE)
        if depth > deepest:
            deepest, where = depth, line
    return deepest, where


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    """Names, words, brackets and "=" with their lines."""
    line = 1
    for match in _TOKEN.finditer(text):
        if match["line"]:
            line += 1
        elif match["label"]:
            line += match["label"].count("\n")
        elif match["name"] or match["word"] or match["mark"]:
            yield match[0], line


def _header(tokens: Iterator[tuple[str, int]]) -> str:
    """The function's name; goes on to the brace before its body."""
    name, depth, listed = "", 0, False
    for token, _ in tokens:
        if token == "{" and not depth and listed:
            break
        depth += (token in _OPEN) - (token in _CLOSE)
        if token[0] == "@" and not name:
            name = bare(token)
        listed = listed or bool(name and token == ")" and not depth)
    return name


def _body(tokens: Iterator[tuple[str, int]]) -> Iterator[int]:
    depth, start, last, local = 0, 0, "", 0
    debug = False
    for token, line in tokens:
        depth += (token in _OPEN) - (token in _CLOSE)
        if depth < 0:
            break
        opens = token in _WITHOUT_RESULT and last not in _BEFORE_CALL and not depth
        if opens or (token == "=" and local):
            if start and not debug:
                yield start
            start, debug = (line if opens else local), False
        debug = debug or token.startswith("@llvm.dbg.")
        local, last = (line if token[0] == "%" else 0), token
    if start and not debug:
        yield start
