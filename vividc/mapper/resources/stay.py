"""A stay of a word in a register."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Stay:
    """Word of node `word` in one register of a PE, readable in cycles `first` .. `last` (at most II
    of them, but in rotating files).
    """

    word: int
    first: int
    last: int
