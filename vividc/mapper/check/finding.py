"""The outcome of checking one statement of a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from vividc.errors import printable

Verdict = Literal["confirmed", "trusted", "wrong"]
_MOST_CHARACTERS: Final = 300


@dataclass(frozen=True, slots=True)
class Finding:
    """One statement of a result, and what became of checking it."""

    verdict: Verdict
    what: str

    def __str__(self) -> str:
        return f"{self.verdict}: {self.what}"


def own_words(text: str) -> str:
    """A file's own words on one line: they cannot pass for a finding."""
    shown = printable(" ".join(text.split()))
    return shown if len(shown) <= _MOST_CHARACTERS else f"{shown[:_MOST_CHARACTERS]}..."
