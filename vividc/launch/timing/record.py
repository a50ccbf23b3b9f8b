"""When every step of a job ran and what served it, from which its events are made on demand: of
many a job nobody looks at them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vividc.launch.event import Event
from vividc.launch.flat import Ints
from vividc.launch.steps import Configure, Execute, Step, kind_of


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
