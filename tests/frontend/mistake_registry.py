"""Registers kernels with what the error about them must say."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Mistake:
    """A kernel of (float32[::1], int32), patterns of the reason and the hint, and the line.

    `line` None: any line of the kernel's file.
    """

    function: Callable[..., object]
    reason: str
    hint: str
    line: int | None


MISTAKES: dict[str, Mistake] = {}


def mistake(reason: str, hint: str) -> Callable[[Callable[..., object]], Callable[..., object]]:
    """Register a function."""

    def register(function: Callable[..., object]) -> Callable[..., object]:
        MISTAKES[function.__name__] = Mistake(function, reason, hint, _line(function))
        return function

    return register


def _line(function: Callable[..., object]) -> int | None:
    lines, first = inspect.getsourcelines(function)
    for number, text in enumerate(lines, start=first):
        if "# here" in text:
            return None if "# here: any" in text else number
        if "# see: " in text:
            return _marked(function, text.split("# see: ")[1].split()[0])
    raise AssertionError(f"{function.__name__} marks no line")


def _marked(function: Callable[..., object], label: str) -> int:
    text = Path(inspect.getfile(function)).read_text(encoding="utf-8")
    return 1 + next(n for n, line in enumerate(text.splitlines()) if f"# here: {label}" in line)
