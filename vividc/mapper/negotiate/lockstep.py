"""Attempts side by side, each on a thread: compiled functions let other threads run."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeAlias, TypeVar

_Value = TypeVar("_Value")

Steps: TypeAlias = Generator[None, None, _Value]
"""Work that comes to a value in small steps."""


def first_result(attempts: Sequence[Steps[_Value | None]]) -> _Value | None:
    """Take a step of each attempt in turn until one returns a value; None: none does.

    Of several that return one after the same number of steps the first counts, so that the result
    does not depend on the speed of threads.
    """
    if len(attempts) == 1:
        return _alone(attempts[0])
    going = list(attempts)
    with ThreadPoolExecutor(len(attempts)) as pool:
        while going:
            steps = [pool.submit(_step, attempt) for attempt in going]
            ended = [step.result() for step in steps]
            found = [end[0] for end in ended if end is not None and end[0] is not None]
            if found:
                return found[0]
            going = [attempt for attempt, end in zip(going, ended, strict=True) if end is None]
    return None


def _alone(attempt: Steps[_Value]) -> _Value:
    while True:
        end = _step(attempt)
        if end is not None:
            return end[0]


def _step(attempt: Steps[_Value]) -> tuple[_Value] | None:
    """One step; the value if that was the last."""
    try:
        next(attempt)
    except StopIteration as stop:
        return (stop.value,)
    return None
