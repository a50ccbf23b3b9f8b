"""Budgets of effort that can be shared out, and the clock that guards them.

Effort is counted, not timed: OR-Tools' deterministic time, moves of the annealer, steps of a
search. Each is charged at a fixed rate in the seconds that it takes on a typical machine. So the
same input is searched the same way on a loaded machine; the clock only ends a search that takes
longer than the user's limit, and the result says so (`Meter.hurried`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from typing import Final

from vividc.host import time_limit
from vividc.host.time_limit import Limit

EFFORT_SHARE: Final = 0.8
"""Seconds of effort that a second of the user's limit buys; the margin is for slower machines."""


@dataclass(slots=True)
class Meter:
    """The effort that one compilation or search has spent, in seconds of a typical machine.

    `most_s`: what it may spend; `guard`: the time limit, whose end has `hurried` it. Charged on one
    thread only.
    """

    most_s: float
    guard: Limit
    spent_s: float = 0.0
    hurried: bool = False

    def charge(self, seconds: float) -> None:
        """Count effort that was spent."""
        self.spent_s += seconds

    def within(self, seconds: float) -> Deadline:
        """The deadline `seconds` of effort from now, or at the end of what may be spent."""
        return Deadline(min(self.most_s, self.spent_s + seconds), self)

    @property
    def guard_s(self) -> float:
        """Seconds that are left on the clock, never negative; at 0 the search is hurried."""
        left_s = self.guard.left_on_the_wall_s
        self.hurried = self.hurried or left_s <= 0.0
        return left_s


_current: ContextVar[Meter | None] = ContextVar("meter", default=None)


@dataclass(frozen=True, slots=True)
class Deadline:
    """A point in a search, in seconds of effort on its meter."""

    at: float
    meter: Meter = field(compare=False, repr=False)

    @staticmethod
    def after(seconds: float) -> Deadline:
        """The deadline `seconds` of effort from now, on the current meter.

        Without one, on a new meter whose clock is generous enough for effort to run out first.
        """
        meter = _current.get()
        if meter is None:
            meter = Meter(seconds, time_limit.limit_of(seconds / EFFORT_SHARE))
        return meter.within(seconds)

    @property
    def remaining_s(self) -> float:
        """Seconds of effort left, never negative; 0 when the clock has run out."""
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
    """The deadline of what runs inside. Inside another limit the meter is shared: this limit then
    counts effort within the outer one, and the clock keeps the limit that holds here.
    """
    outer = _current.get()
    if outer is not None:
        with _guarded(outer):
            yield outer.within(time_limit_s)
        return
    effort_s = time_limit_s * EFFORT_SHARE
    with time_limit.limited(time_limit_s, grace_s=math.inf) as guard:
        meter = Meter(effort_s, guard)
        token = _current.set(meter)
        try:
            yield meter.within(effort_s)
        finally:
            _current.reset(token)


@contextmanager
def _guarded(meter: Meter) -> Iterator[None]:
    """Have the meter guarded by the time limit that holds here, with a `hurried` of its own."""
    before, hurried = meter.guard, meter.hurried
    meter.guard, meter.hurried = time_limit.current() or before, False
    try:
        yield
    finally:
        meter.guard, meter.hurried = before, hurried or meter.hurried
