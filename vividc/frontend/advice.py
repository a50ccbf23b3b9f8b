"""Hints on what to write instead, in the language that the kernel is written in."""

from __future__ import annotations

from typing import Self


class Advice(str):
    """Advice of the stages that Python's kernels and C's share: Python's, and beside it C's."""

    c: str

    def __new__(cls, python: str, *, c: str) -> Self:
        """The text is for Python."""
        made = super().__new__(cls, python)
        made.c = c
        return made


def in_c(hint: str) -> str:
    """The hint for a kernel in C."""
    return hint.c if isinstance(hint, Advice) else hint
