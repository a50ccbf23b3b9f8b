"""The interface between a launch and the engine that runs it, and what every engine returns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from operator import attrgetter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vividc.program import Program

Progress = Callable[[int], None]
"""Called now and then with the cycles run so far."""


@dataclass(frozen=True, slots=True)
class RegionSpan:
    """One run of one region.

    Attributes
    ----------
    region
        Its row in the region table.
    start, end
        First cycle, and the cycle after the last.
    iterations
        Live iterations.
    bank_stalls
        Cycles among them that the tile stood still.
    """

    region: int
    start: int
    end: int
    iterations: int
    bank_stalls: int


Observer = Callable[[RegionSpan], None]
"""Called after each run of a region, in order."""


@dataclass(frozen=True, slots=True)
class Launch:
    """What the host gives a program.

    Attributes
    ----------
    memory
        Scratchpad contents: uint32 words. An engine works on a copy.
    inputs
        Word of each launch key (see `program.LaunchRow`).
    cycle_limit
        Cycles after which the run is an error.
    extents
        First byte and end of each array, by name; an access to it elsewhere is an error. An array
        that is not named may be anywhere in the scratchpad.
    observer
        Told of every run of a region; it costs the native engine a call each.
    """

    memory: NDArray[np.uint32]
    inputs: Mapping[str, int]
    cycle_limit: int
    extents: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    progress: Progress | None = None
    observer: Observer | None = None


@dataclass(frozen=True, slots=True)
class Activity:
    """Words moved in a region or a whole run; moves of invalid words are not counted.

    Attributes
    ----------
    link_words
        Words driven onto links.
    register_reads, register_writes
        RF reads by operands, links, copies and live-outs; RF writes.
    constant_reads, constant_writes
        Constant-store reads by operands and addresses; live-outs.
    scratchpad_reads, scratchpad_writes
        Accesses to the scratchpad.
    """

    link_words: int = 0
    register_reads: int = 0
    register_writes: int = 0
    constant_reads: int = 0
    constant_writes: int = 0
    scratchpad_reads: int = 0
    scratchpad_writes: int = 0

    @staticmethod
    def total(parts: Iterable[Activity]) -> Activity:
        """The sum of `parts`."""
        counts = [_counts_of(part) for part in parts]
        return Activity(*map(sum, zip(*counts, strict=True)))


_counts_of = attrgetter(*(count.name for count in fields(Activity)))


@dataclass(frozen=True, slots=True)
class RegionRun:
    """Activity of one region, summed over all its runs.

    Attributes
    ----------
    entries
        Times the region ran.
    iterations
        Live iterations; speculative ones that an exit killed are not among them.
    cycles
        Cycles of the region, stalls included.
    bank_stalls
        Cycles the tile stood still because accesses met in a bank.
    issued
        Operations issued, by opcode name, those of killed iterations included.
    activity
        Words that moved.
    """

    entries: int
    iterations: int
    cycles: int
    bank_stalls: int
    issued: Mapping[str, int]
    activity: Activity = Activity()


class Counts(Protocol):
    """What a run counted."""

    def regions(self) -> tuple[RegionRun, ...]:
        """One per row of the region table."""


@dataclass(frozen=True, slots=True)
class ByRegion:
    """Counts that were kept region by region."""

    rows: tuple[RegionRun, ...]

    def regions(self) -> tuple[RegionRun, ...]:
        """See `Counts`."""
        return self.rows


@dataclass(frozen=True, slots=True)
class Run:
    """The outcome of a launch.

    Attributes
    ----------
    cycles
        Cycles from the first of region 0 to the last of the last region, stalls included.
    switch_cycles
        Those of them that passed between regions.
    reload_cycles
        Those of these in which contexts were brought (docs/machine.md, "Long programs").
    memory
        Scratchpad contents at the end: uint32 words.
    value
        The word of the returned scalar, if the program returns one.
    counts
        What it counted: few runs of a job are looked at one by one.
    engine
        Name of the engine that ran it.
    """

    cycles: int
    switch_cycles: int
    memory: NDArray[np.uint32]
    value: int | None
    counts: Counts
    engine: str = "reference"
    reload_cycles: int = 0

    @property
    def regions(self) -> tuple[RegionRun, ...]:
        """One per row of the region table; made anew each time."""
        return self.counts.regions()

    @property
    def activity(self) -> Activity:
        """Words moved in all regions."""
        return Activity.total(region.activity for region in self.regions)


class Engine(Protocol):
    """Runs the words of one program, as often as wanted."""

    def run(self, launch: Launch) -> Run:
        """Run the program once.

        Raises
        ------
        SimulationError
            The program did something the machine forbids, or the cycle limit was reached.
        """


EngineFactory = Callable[[Program], Engine]
