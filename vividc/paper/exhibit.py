"""A table or figure of the paper: lines with ours, theirs and a verdict, pictures, assumptions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from vividc.errors import InternalError
from vividc.host.plot import Picture

Verdict = Literal["reproduced", "different", "not reproducible here", "not measured"]
Theirs = float | tuple[float, float] | None
WITHIN: Final = 0.10
"""Of theirs, or of an end of their range: reproduced."""


@dataclass(frozen=True, slots=True)
class Line:
    """One figure.

    Attributes
    ----------
    ours
        None: there is none.
    theirs
        A number or a range; None: not published.
    verdict, because
        Every verdict but "reproduced" has a reason.
    """

    what: str
    ours: float | None
    theirs: Theirs
    unit: str
    verdict: Verdict
    because: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """More figures of ours, as text."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class Exhibit:
    """A table or figure.

    Attributes
    ----------
    assumptions
        Each with how far it moves the result.
    """

    name: str
    title: str
    lines: Sequence[Line]
    tables: Sequence[Table] = ()
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    assumptions: Sequence[str] = ()


def judged(
    what: str, ours: float | None, theirs: Theirs, unit: str, because: str, *, most: bool = False
) -> Line:
    """Return a line with its verdict.

    Parameters
    ----------
    because
        Why ours is another figure, or why there is none.
    most
        Theirs is a limit: whatever is at most as large reproduces it.
    """
    if not because:
        raise InternalError(f"{what}: no reason is given for a difference")
    if ours is None:
        return Line(what, None, theirs, unit, "not measured", because)
    if theirs is None:
        return Line(what, ours, None, unit, "not reproducible here", because)
    low, high = theirs if isinstance(theirs, tuple) else (theirs, theirs)
    if (most or low - WITHIN * abs(low) <= ours) and ours <= high + WITHIN * abs(high):
        return Line(what, ours, theirs, unit, "reproduced")
    return Line(what, ours, theirs, unit, "different", because)


def shown(value: float | None, form: str) -> str:
    """A figure of a table, in one of Python's formats; "-": there is none."""
    return "-" if value is None else format(value, form)


def tenths(value: float | None) -> str:
    """A figure with one decimal."""
    return shown(value, ".1f")


def decibel(value: float | None) -> str:
    """A figure with two decimals."""
    return shown(value, ".2f")


def missing(what: str, theirs: Theirs, unit: str, because: str) -> Line:
    """Return a line of a figure that nothing here can give."""
    return Line(what, None, theirs, unit, "not reproducible here", because)
