"""When each step of a job ran and what served it, and the events made from that on demand: few jobs
are ever looked at that closely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Literal

import numpy as np

from vividc.launch.flat import Ints
from vividc.launch.steps import Configure, Execute, Kind, Step, kind_of

Unit = Literal["tile", "dma", "configuration"]


@dataclass(frozen=True, slots=True)
class Event:
    """A unit was busy with a step.

    Attributes
    ----------
    unit, index
        "tile" and its number, "dma" and its engine, or "configuration".
    kind
        What the step does.
    step
        Its number in the graph.
    start, end
        First cycle, and the cycle after the last.
    size_bytes
        Bytes moved; 0 for runs and configuration.
    program
        Name of the program run or configured.
    tiles
        The tiles concerned.
    """

    unit: Unit
    index: int
    kind: Kind
    step: int
    start: int
    end: int
    size_bytes: int = 0
    program: str = ""
    tiles: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """By step, int64: first cycle and the one after the last, the DMA engine of a transfer, and the
    bytes that it moved.
    """

    steps: Sequence[Step]
    start: Ints
    end: Ints
    engine: Ints
    size_bytes: Ints

    def events(self) -> tuple[Event, ...]:
        """What every unit did, by start."""
        arrays = (self.start, self.end, self.engine, self.size_bytes)
        rows = zip(self.steps, *(array.tolist() for array in arrays), strict=True)
        events = [_event(number, *row) for number, row in enumerate(rows)]
        return tuple(sorted(events, key=lambda e: (e.start, e.unit, e.index, e.step)))


def joined_record(parts: Sequence[tuple[Record, int]]) -> Record:
    """Records of jobs that ran one after the other, each with its cycles."""
    starts = [0, *accumulate(cycles for _, cycles in parts)]
    records = [record for record, _ in parts]
    pairs = list(zip(starts, records, strict=False))
    return Record(
        steps=[step for record in records for step in record.steps],
        start=np.concatenate([at + record.start for at, record in pairs]),
        end=np.concatenate([at + record.end for at, record in pairs]),
        engine=np.concatenate([record.engine for record in records]),
        size_bytes=np.concatenate([record.size_bytes for record in records]),
    )


def _event(number: int, step: Step, start: int, end: int, engine: int, size: int) -> Event:
    if isinstance(step, Execute):
        name = step.program.name
        return Event("tile", step.tile, "run", number, start, end, program=name, tiles=(step.tile,))
    if isinstance(step, Configure):
        name = step.programs[0].name
        return Event(
            "configuration", 0, "configure", number, start, end, program=name, tiles=step.tiles
        )
    return Event("dma", engine, kind_of(step), number, start, end, size, tiles=step.tiles)
