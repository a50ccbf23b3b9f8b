"""Budgets of effort that can be shared out, and the clock that guards them.

Effort is counted, not timed: OR-Tools' deterministic time, moves of the annealer, steps of a
search. Each is charged at a fixed rate in the seconds that it takes on a typical machine. So the
same input is searched the same way on a loaded machine; the clock only ends a search that takes
longer than the user's limit, and that is told (`Meter.hurried`).
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from typing import Final

from vividc.errors import VividcError, demand_type

EFFORT_SHARE: Final = 0.8
"""Seconds of effort that a second of the user's limit buys; the rest is for slower machines."""


@dataclass(slots=True)
class Meter:
    """The effort that one compilation or search has spent, in seconds of a typical machine.

    `guard_at`: when the clock ends it, in seconds of the monotonic clock; `hurried`: it has;
    `most_s`: the effort that it may spend. Charged on one thread only.
    """

    guard_at: float
    most_s: float
    spent_s: float = 0.0
    hurried: bool = False

    def charge(self, seconds: float) -> None:
        """Count effort that was spent."""
        self.spent_s += seconds

    def pause(self, seconds: float) -> None:
        """Set the guard later, by time that is not the search's."""
        self.guard_at += seconds

    def within(self, seconds: float) -> Deadline:
        """The deadline `seconds` of effort from now, or at the end of what may be spent."""
        return Deadline(min(self.most_s, self.spent_s + seconds), self)

    @property
    def guard_s(self) -> float:
        """Seconds that the clock leaves, never negative; none: the search is hurried."""
        left = self.guard_at - time.monotonic()
        self.hurried = self.hurried or left <= 0.0
        return max(left, 0.0)


_patience: ContextVar[float] = ContextVar("patience", default=1.0)
_current: ContextVar[Meter | None] = ContextVar("meter", default=None)


@dataclass(frozen=True, slots=True)
class Deadline:
    """A point in a search, in seconds of effort on its meter."""

    at: float
    meter: Meter = field(compare=False, repr=False)

    @staticmethod
    def after(seconds: float) -> Deadline:
        """The deadline `seconds` of effort from now, on the meter that runs.

        Without one: on a new one whose clock allows so much that effort comes first.
        """
        meter = _current.get()
        if meter is None:
            guard_s = seconds / EFFORT_SHARE * _patience.get()
            meter = Meter(time.monotonic() + guard_s, seconds)
        return meter.within(seconds)

    @property
    def remaining_s(self) -> float:
        """Seconds of effort left, never negative; none when the clock has run out."""
        left = self.at - self.meter.spent_s
        return left if left > 0.0 and self.meter.guard_s > 0.0 else 0.0

    @property
    def passed(self) -> bool:
        """No effort is left."""
        return self.remaining_s <= 0.0

    def within(self, seconds: float) -> Deadline:
        """The earlier of this deadline and `seconds` of effort from now."""
        return replace(self, at=min(self.at, self.meter.spent_s + seconds))

    def charge(self, seconds: float) -> None:
        """Count effort that was spent."""
        self.meter.charge(seconds)


@contextmanager
def limited(time_limit_s: float) -> Iterator[Deadline]:
    """The deadline of what runs inside. What is limited already shares its meter: the limit is
    then one of effort, within that of the whole.
    """
    meter = _current.get()
    if meter is not None:
        yield meter.within(time_limit_s)
        return
    effort_s = time_limit_s * EFFORT_SHARE
    meter = Meter(time.monotonic() + time_limit_s * _patience.get(), effort_s)
    token = _current.set(meter)
    try:
        yield meter.within(effort_s)
    finally:
        _current.reset(token)


@contextmanager
def patient(times: float) -> Iterator[None]:
    """Have the clock allow so many times the time limit of what is compiled or mapped inside.

    The effort that a limit buys stays the same, and so does what it finds where the clock does not
    end it: a benchmark in it gives the same figures beside other work (`docs/mappers.md`).

    Raises
    ------
    VividcError
        `times` is no positive number.
    """
    demand_type(times, (int, float), "the patience", "give how many times the limit it may take")
    if not times > 0:
        raise VividcError(f"the patience must be positive, not {times}", loc="times")
    token = _patience.set(times)
    try:
        yield
    finally:
        _patience.reset(token)
