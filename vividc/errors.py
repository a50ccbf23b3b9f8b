"""Every error vividc raises on purpose, and how a user's names and values stand in it.

A value is on one line, and not too long.
"""

from __future__ import annotations

import builtins
import contextlib
import functools
import os
import sys
import warnings
from dataclasses import dataclass
from typing import Final

_MOST = 200
"""Characters of a source line in a message."""

_MOST_SOURCE_BYTES = 16 << 20

_OURS: Final = (os.path.dirname(__file__) + os.sep, contextlib.__file__, functools.__file__)
"""Files of vividc's frames, and of what is between them: decorators."""

_CUT: Final = "..."
_LINES: Final = 40
_LINE: Final = 500
_CLOSING: Final = frozenset("'\")]}>")


@dataclass(frozen=True, slots=True, order=True)
class SourceLoc:
    """A line of the user's source. `line` counts from 1; columns are not known to numba."""

    file: str
    line: int

    def __str__(self) -> str:
        here = os.getcwd() + os.sep
        return f"{self.file.removeprefix(here)}:{self.line}"


class VividcError(Exception):
    """Root of all errors that a user can cause; shown as one message, never as a traceback.

    Parameters
    ----------
    reason
        What is wrong, in one sentence without a final dot.
    loc
        The source line, or a string that names the option or the file.
    hint
        A way out.
    """

    exit_code = 2

    def __init__(
        self, reason: str, *, loc: SourceLoc | str | None = None, hint: str | None = None
    ) -> None:
        self.reason = reason
        self.loc = loc
        self.hint = hint
        super().__init__(self._message())

    def _message(self) -> str:
        reason = shortened(self.reason)
        head = reason if self.loc is None else f"{self.loc}: {reason}"
        lines = [head]
        if isinstance(self.loc, SourceLoc):
            text = _source_line(self.loc)
            if text:
                lines.append(f"    {text}")
        if self.hint:
            lines.append(f"hint: {shortened(self.hint)}")
        return "\n".join(lines)


class KernelError(VividcError):
    """The kernel uses something that cannot be compiled."""


class ArgumentError(VividcError):
    """The arguments of a run do not fit the kernel's signature or the machine."""


class DFGError(VividcError):
    """A dataflow graph is malformed or could not be read."""


class SSAError(VividcError):
    """The text of a function in SSA form is malformed."""


class ArchError(VividcError):
    """A fabric description is malformed or unknown."""


class BundleError(VividcError):
    """A `.vivid` file is missing, truncated, or of another version."""


class MappingFailed(VividcError):
    """A region has no mapping: proved infeasible (exit code 3)."""

    exit_code = 3


class TimeLimit(VividcError):
    """Something was not done within the time limit (exit code 4)."""

    exit_code = 4


class SimulationError(VividcError):
    """The program did something that the machine forbids; it names PE and cycle."""


class KernelRaised(SimulationError):
    """The kernel raised an exception; it is one of that type, too, if Python has it."""


def raised(kind: str, text: str, loc: str | SourceLoc | None) -> KernelRaised:
    """The exception that a kernel raised, by the name of its type."""
    found = getattr(builtins, kind, None)
    bases: tuple[type, ...] = (KernelRaised,)
    if isinstance(found, type) and issubclass(found, Exception):
        bases = (KernelRaised, found)
    name = kind if kind.isidentifier() else KernelRaised.__name__
    what = f"{kind}: {text}" if text else kind
    try:
        return _raised(name, bases, what, loc)
    except TypeError:  # one that is made of more than a text, as UnicodeDecodeError
        return _raised(name, (KernelRaised,), what, loc)


def _raised(
    name: str, bases: tuple[type, ...], what: str, loc: str | SourceLoc | None
) -> KernelRaised:
    made: KernelRaised = type(name, bases, {"__doc__": KernelRaised.__doc__})(what, loc=loc)
    return made


class CycleLimit(SimulationError):
    """A run was given up after its limit of cycles (exit code 4)."""

    exit_code = 4


class VividcWarning(UserWarning):
    """The kernel compiles, but may compute something else than was written."""


def warn(text: str, category: type[Warning] = VividcWarning) -> None:
    """Warn, with the line outside vividc that led to it: that of the user's call."""
    frame, level = sys._getframe(1), 2
    while frame.f_code.co_filename.startswith(_OURS) and frame.f_back is not None:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)


class InternalError(Exception):
    """A bug of vividc: the message says how to report it."""

    exit_code = 1

    def __init__(self, what: str) -> None:
        super().__init__(f"{what}\nThis is a bug of vividc; please report it with the input.")


def demand_type(value: object, expected: type | tuple[type, ...], what: str, hint: str) -> None:
    """Refuse an argument of the wrong type; a bool is no number.

    Raises
    ------
    ArgumentError
        `value` is not an instance of `expected`.
    """
    wanted = expected if isinstance(expected, tuple) else (expected,)
    odd_bool = isinstance(value, bool) and int in wanted and bool not in wanted
    if odd_bool or not isinstance(value, expected):
        raise ArgumentError(f"{what} cannot be {quoted(value)}", hint=hint)


def demand_callable(value: object, what: str) -> None:
    """Refuse what is neither None nor can be called.

    Raises
    ------
    ArgumentError
        It is something else.
    """
    if value is not None and not callable(value):
        raise ArgumentError(f"{what} cannot be {quoted(value)}", hint="give a function, or None")


def _source_line(loc: SourceLoc) -> str:
    try:
        if not os.path.isfile(loc.file) or os.path.getsize(loc.file) > _MOST_SOURCE_BYTES:
            return ""  # a file may name any other, such as a device
        with open(loc.file, encoding="utf-8") as source:
            for number, text in enumerate(source, start=1):
                if number == loc.line:
                    return printable(text.strip()[:_MOST])
    except (OSError, UnicodeDecodeError):
        pass
    return ""


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
