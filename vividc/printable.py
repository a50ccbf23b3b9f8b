"""How names and values that a user gave stand in a message: on one line, and not too long."""

from __future__ import annotations

from typing import Final

_CUT: Final = "..."
_LINES: Final = 40
_LINE: Final = 500
_CLOSING: Final = frozenset("'\")]}>")


def printable(text: str) -> str:
    """`text` with control characters, line ends and the like as escapes: a terminal obeys none."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escape(c) for c in text)


def quoted(value: object, most: int = 60) -> str:
    """`repr` of a value of at most `most` characters; what is cut keeps its closing mark."""
    try:
        text = printable(repr(value))
    except ValueError:  # Python writes out no integer of thousands of digits
        return "a number of too many digits"
    if len(text) <= most:
        return text
    end = text[-1] if text[-1] in _CLOSING else ""
    return f"{text[: most - len(_CUT) - len(end)]}{_CUT}{end}"


def shortened(text: str) -> str:
    """A message of at most 40 lines of 500 characters, whatever a file's names and numbers are."""
    if len(text) <= _LINE:
        return text
    lines = text.split("\n")
    shown = [line if len(line) <= _LINE else line[: _LINE - 3] + _CUT for line in lines[:_LINES]]
    if len(lines) > _LINES:
        shown.append(f"{_CUT} and {len(lines) - _LINES} more lines")
    return "\n".join(shown)


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
