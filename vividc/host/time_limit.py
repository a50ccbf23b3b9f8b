"""The time limit of a compilation, which its stages ask between their steps.

A guard only: what is searched, and for how long, follows from effort (`mapper/deadline.py`). Where
time is up, a stage that cannot go without a result ends with a message; one that can leaves the
rest out, and what is made of that says so: results depend on the clock nowhere else.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace

from vividc.errors import SourceLoc, TimeLimit, VividcError, demand_type

_HINT = "give a longer --time-limit (time_limit_s), or split the kernel"


@dataclass(frozen=True)
class Limit:
    """What is to be done by when, by `now`, and by when at the very latest, with nothing else to be
    had; `cut` says what was left out for want of time. `times`: the patience that it was set with.
    """

    at: float
    last: float
    seconds: float
    times: float = 1.0
    what: str = ""
    loc: SourceLoc | None = None
    cut: list[str] = field(default_factory=list)

    @property
    def left_s(self) -> float:
        """Seconds left, never negative, on any thread."""
        return max(self.at - _read(self.times), 0.0)

    @property
    def left_on_the_wall_s(self) -> float:
        """The same, in seconds of a clock that knows no patience."""
        return self.left_s * self.times


_current: ContextVar[Limit | None] = ContextVar("time limit", default=None)
_patience: ContextVar[float] = ContextVar("patience", default=1.0)


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


def now() -> float:
    """Seconds of the clock that limits are kept by: it is slower where there is patience."""
    return _read(_patience.get())


def _read(times: float) -> float:
    return time.monotonic() / times


def current() -> Limit | None:
    """The limit that holds here, if one does."""
    return _current.get()


def limit_of(seconds: float) -> Limit:
    """A limit that holds for nobody yet, from now."""
    at = now() + seconds
    return Limit(at, at, seconds, _patience.get())


@contextmanager
def limited(
    seconds: float, what: str = "", loc: SourceLoc | None = None, *, grace_s: float = 0.0
) -> Iterator[Limit]:
    """What is done inside has so many seconds, and no more than are left outside.

    Parameters
    ----------
    what, loc
        What is not done if time is up, and where it stands; of the limit outside if there is one.
    grace_s
        So many seconds later `step` ends what is not done. It is for what is needed in any case.
    """
    outer, at = _current.get(), now() + seconds
    limit = Limit(at, at + grace_s, seconds, _patience.get(), what, loc)
    if outer is not None:
        limit = replace(
            outer, at=min(limit.at, outer.at), last=min(limit.last, outer.last), cut=outer.cut
        )
    token = _current.set(limit)
    try:
        yield limit
    finally:
        _current.reset(token)


def remaining_s() -> float:
    """Seconds left, never negative; infinite without a limit."""
    limit = _current.get()
    return math.inf if limit is None else limit.left_s


def step(doing: str) -> None:
    """What stages call between their steps.

    Raises
    ------
    TimeLimit
        Time is up while `doing` that, such as "its loops are scheduled".
    """
    limit = _current.get()
    if limit is None or now() < limit.last:
        return
    what = limit.what or "this"
    reason = f"{what} was not compiled within {limit.seconds:g} s: time was up while {doing}"
    raise TimeLimit(reason, loc=limit.loc, hint=_HINT)


def left_out(what: str) -> None:
    """Note that something was cut short or left out for want of time; the program will say so."""
    limit = _current.get()
    if limit is not None and what not in limit.cut:
        limit.cut.append(what)
