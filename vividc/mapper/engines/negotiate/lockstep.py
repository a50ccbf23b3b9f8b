"""Attempts side by side, each on its own thread: compiled functions release the interpreter.

What comes of them is what comes of steps in turn, one of each, but where there is effort left for
many steps each thread takes some without waiting for the others: steps differ in length.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Final, Generic, TypeAlias, TypeVar

_Value = TypeVar("_Value")

Steps: TypeAlias = Generator[float, None, _Value]
"""Work that comes to a value in small steps, and yields the effort of each, in seconds."""

_MANY: Final = 16
_AMPLE_S: Final = 1.0
"""Steps that a thread takes alone while there is so much effort left, as they take at most: 0.02 s
each. What an attempt asks of its deadline meanwhile it would be told in turn, too: that some is
left.
"""


def first_result(
    attempts: Sequence[Steps[_Value | None]],
    charge: Callable[[float], None] = lambda _: None,
    threads: int | None = None,
    left_s: Callable[[], float] = lambda: math.inf,
) -> _Value | None:
    """Take a step of each attempt in turn until one returns a value; None: none does.

    Of several that return one after the same number of steps the first counts, so that the result
    does not depend on the number of `threads` (None: one each) or their speed. The longest step is
    charged for each round; `left_s`: what may still be.
    """
    if len(attempts) == 1:
        return _alone(attempts[0], charge)
    going = list(attempts)
    with ThreadPoolExecutor(threads or len(attempts)) as pool:
        while going:
            turn = _Turn(_many(left_s), is_race=True)
            ends: list[_Taken[_Value | None]] = list(pool.map(turn.run, going))
            for number in range(max(end.rounds for end in ends)):
                charge(max(end.effort(number) for end in ends))
                values = (end.value for end in ends if end.rounds == number + 1 and end.value)
                found = [value for (value,) in values if value is not None]
                if found:
                    return found[0]
            going = [one for one, end in zip(going, ends, strict=True) if end.value is None]
    return None


def every_result(
    attempts: Sequence[Steps[_Value]],
    charge: Callable[[float], None],
    threads: int,
    left_s: Callable[[], float] = lambda: math.inf,
) -> list[_Value]:
    """Take a step of each attempt in turn until all have returned a value."""
    if len(attempts) == 1:
        return [_alone(attempts[0], charge)]
    going, found = dict(enumerate(attempts)), dict[int, _Value]()
    with ThreadPoolExecutor(threads) as pool:
        while going:
            turn = _Turn(_many(left_s))
            ended = dict(zip(going, pool.map(turn.run, going.values()), strict=True))
            for number in range(max(end.rounds for end in ended.values())):
                charge(max(end.effort(number) for end in ended.values()))
            found |= {number: end.value[0] for number, end in ended.items() if end.value}
            going = {number: going[number] for number in ended if number not in found}
    return [found[number] for number in range(len(attempts))]


@dataclass(slots=True)
class _Taken(Generic[_Value]):
    """Efforts of the steps that an attempt took, and its value, if the last of them came to one,
    alone in a tuple.
    """

    efforts: list[float] = field(default_factory=list)
    value: tuple[_Value] | None = None

    @property
    def rounds(self) -> int:
        """How many steps there were, with the last one."""
        return len(self.efforts) + (self.value is not None)

    def effort(self, number: int) -> float:
        """Of a step; the last one has none, as those have that were not taken."""
        return self.efforts[number] if number < len(self.efforts) else 0.0

    def step(self, attempt: Steps[_Value]) -> None:
        """Take one more."""
        try:
            self.efforts.append(next(attempt))
        except StopIteration as stop:
            self.value = (stop.value,)


@dataclass(slots=True)
class _Turn:
    """Steps of some attempts, `most` of each; in a race no more than one took that has come to
    something.
    """

    most: int
    is_race: bool = False

    def run(self, attempt: Steps[_Value]) -> _Taken[_Value]:
        """Those of one."""
        taken = _Taken[_Value]()
        while taken.rounds < self.most and taken.value is None:
            taken.step(attempt)
        if self.is_race and taken.value is not None and taken.value[0] is not None:
            self.most = min(self.most, taken.rounds)
        return taken


def _many(left_s: Callable[[], float]) -> int:
    """How many steps each thread may take by itself."""
    return _MANY if left_s() > _AMPLE_S else 1


def _alone(attempt: Steps[_Value], charge: Callable[[float], None]) -> _Value:
    while True:
        try:
            charge(next(attempt))
        except StopIteration as stop:
            value: _Value = stop.value
            return value
