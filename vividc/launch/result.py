"""What a job gives: cycles, returned values, statistics, and what every unit did when."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass

from vividc.launch.accounting import JobStats
from vividc.launch.event import Event
from vividc.launch.timing.record import Record


@dataclass(frozen=True, slots=True)
class JobResult:
    """The outcome of a job.

    Attributes
    ----------
    cycles
        From the first cycle to the end of the last step.
    value
        What a spread kernel returns; None for a graph made by hand.
    values
        What each run returned, by step number; `words`: the same as words.
    stats
        Where the cycles of each tile went, and the bytes moved at each level.
    record
        What `events` are made from.
    """

    cycles: int
    value: int | float | bool | None
    values: ReadOnly[int, int | float | bool | None]
    words: ReadOnly[int, int]
    stats: JobStats
    record: Record

    @property
    def events(self) -> tuple[Event, ...]:
        """What every unit did, by start; made anew each time."""
        return self.record.events()
