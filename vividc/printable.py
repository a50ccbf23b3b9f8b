"""How names and values that a user gave stand in a message: on one line, and not too long."""

from __future__ import annotations

from typing import Final

_CUT: Final = "..."
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


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
