"""Attempts side by side, each on its own thread: compiled functions release the interpreter."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeAlias, TypeVar

_Value = TypeVar("_Value")

Steps: TypeAlias = Generator[float, None, _Value]
"""Work that comes to a value in small steps, and yields the effort of each, in seconds."""


def first_result(
    attempts: Sequence[Steps[_Value | None]],
    charge: Callable[[float], None] = lambda _: None,
    threads: int | None = None,
) -> _Value | None:
    """Take a step of each attempt in turn until one returns a value; None: none does.

    Of several that return one after the same number of steps the first counts, so that the result
    does not depend on the number of `threads` (None: one each) or their speed. The longest step is
    charged after each round.
    """
    if len(attempts) == 1:
        return _alone(attempts[0], charge)
    going = list(attempts)
    with ThreadPoolExecutor(threads or len(attempts)) as pool:
        while going:
            steps = [pool.submit(_step, attempt) for attempt in going]
            ended = [step.result() for step in steps]
            charge(max((end for end in ended if isinstance(end, float)), default=0.0))
            results = [end[0] for end in ended if isinstance(end, tuple) and end[0] is not None]
            if results:
                return results[0]
            pairs = zip(going, ended, strict=True)
            going = [attempt for attempt, end in pairs if isinstance(end, float)]
    return None


def every_result(
    attempts: Sequence[Steps[_Value]], charge: Callable[[float], None], threads: int
) -> list[_Value]:
    """Take a step of each attempt in turn until all have returned a value."""
    if len(attempts) == 1:
        return [_alone(attempts[0], charge)]
    going, found = dict(enumerate(attempts)), dict[int, _Value]()
    with ThreadPoolExecutor(threads) as pool:
        while going:
            steps = {number: pool.submit(_step, attempt) for number, attempt in going.items()}
            ended = {number: step.result() for number, step in steps.items()}
            charge(max((end for end in ended.values() if isinstance(end, float)), default=0.0))
            found |= {number: end[0] for number, end in ended.items() if isinstance(end, tuple)}
            going = {number: going[number] for number in ended if number not in found}
    return [found[number] for number in range(len(attempts))]


def _alone(attempt: Steps[_Value], charge: Callable[[float], None]) -> _Value:
    while True:
        end = _step(attempt)
        if isinstance(end, tuple):
            return end[0]
        charge(end)


def _step(attempt: Steps[_Value]) -> tuple[_Value] | float:
    """One step: its effort, or the value if it was the last."""
    try:
        return next(attempt)
    except StopIteration as stop:
        return (stop.value,)
