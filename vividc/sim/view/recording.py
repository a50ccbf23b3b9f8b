"""What a tile did in a window of cycles, seen by the reference engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.errors import ArgumentError, CycleLimit, SimulationError, demand_type
from vividc.program import Program
from vividc.program.reloads import reloads_of
from vividc.sim.bind import bind
from vividc.sim.engine import Launch, RegionSpan
from vividc.sim.reference.engine import ReferenceEngine
from vividc.sim.reference.predecode import RegionCode, Slot, State, StateMap

NOTHING: Final = -1
"""In place of a word: nothing valid."""


@dataclass(frozen=True, slots=True)
class Issued:
    """An operation that issued: its PE, its name, its iteration."""

    pe: int
    op: str
    iteration: int


@dataclass(frozen=True)
class Recording:
    """The cycles of a window in which the tile did not stand still, in order.

    Attributes
    ----------
    first, end
        The window; it ends at the run's end if that came before.
    cycles, regions, slots
        Of each sample: cycle since the launch, region, and context of the region.
    issued
        Of each sample: what issued.
    words
        int64 [samples, words of the tile]: what PEs could read, `NOTHING` where nothing was valid;
        in the order of `predecode.StateMap`: links, registers, output registers.
    touched
        Of each sample: the words of the scratchpad that were accessed, one for each access.
    spans
        Regions that ran to their end inside the window, or began before it.
    stopped
        The error that ended the run inside the window.
    """

    program: Program
    first: int
    end: int
    cycles: NDArray[np.int64]
    regions: NDArray[np.int64]
    slots: NDArray[np.int64]
    issued: tuple[tuple[Issued, ...], ...]
    words: NDArray[np.int64]
    touched: tuple[tuple[int, ...], ...]
    spans: tuple[RegionSpan, ...]
    stopped: str | None = None

    def stalled(self) -> NDArray[np.bool_]:
        """Which cycles of the window the tile stood still inside a region: bool [end - first]."""
        still: NDArray[np.bool_] = np.ones(self.end - self.first, np.bool_)
        still[self.cycles - self.first] = False
        between = np.ones(self.end - self.first, np.bool_)
        for span in self.spans:
            between[max(0, span.start - self.first) : max(0, span.end - self.first)] = False
        start = self._open_start()
        if self.cycles.size and self.cycles[-1] >= start:
            between[max(0, start - self.first) :] = False
        return still & ~between

    def _open_start(self) -> int:
        """Where the region starts that follows the last that ended."""
        if not self.spans:
            return 0
        last = self.spans[-1]
        if self.program.table[last.region].drain and last.iterations:
            return last.end
        switched = last.end + self.program.fabric.controller.switch_cycles
        goes_on = (self.cycles >= last.end) & (self.cycles < switched)
        if self.program.table[last.region].fill and goes_on.any():
            return last.end
        if reloads_of(self.program) is None:
            return switched
        seen = self.cycles[self.cycles >= switched]  # it begins when its contexts are there
        return int(seen[0]) if seen.size else self.end


def record(
    program: Program,
    args: Sequence[object],
    kwargs: Mapping[str, object],
    *,
    window: tuple[int, int] = (0, 1000),
    words: bool = True,
) -> Recording:
    """Run a program on the reference engine up to the end of a window; nothing of the caller's
    changes.

    A run that goes wrong inside the window is recorded up to there.

    Parameters
    ----------
    args, kwargs
        As `simulate` takes them.
    window
        First cycle and the one after the last.
    words
        Record what PEs could read, too.

    Raises
    ------
    ArgumentError
        The window is empty, or the arguments do not fit.
    """
    demand_type(program, Program, "the program", "compile a kernel, or vividc.load a .vivid file")
    first, end = window
    if not 0 <= first < end:
        raise ArgumentError(f"the window {first}:{end} is empty", hint="give FIRST:END, as 0:1000")
    bound = bind(program, args, kwargs)
    watch = _Watch(program, first, end, words)
    spans: list[RegionSpan] = []
    limit = end + _longest_reload(program)  # a region is told of when the next one can begin
    launch = Launch(bound.memory, bound.inputs, limit, bound.extents, observer=spans.append)
    stopped = None
    try:
        end = min(end, ReferenceEngine(program, watch).run(launch).cycles)
    except CycleLimit:
        pass
    except SimulationError as error:
        if watch.last < end:
            stopped, end = error.reason, watch.last + 1
    inside = tuple(span for span in spans if span.end <= end)
    return watch.recording(max(first, end), inside, stopped)


def _longest_reload(program: Program) -> int:
    reloads = reloads_of(program)
    return 0 if reloads is None else max(row.cycles for row in reloads.rows)


def _slots(region: RegionCode) -> tuple[tuple[Slot, ...], ...]:
    return region.rest, region.slots


def _by_pe(issued: Issued) -> int:
    return issued.pe


class _Watch:
    """Samples the cycles of a window."""

    def __init__(self, program: Program, first: int, end: int, words: bool) -> None:
        cells = StateMap(program.fabric)
        self._program = program
        self._first, self._end = first, end
        self._kept = cells.res_base if words else 0
        self._slots: dict[int, dict[int, int]] = {}
        self._samples: list[tuple[int, int, int]] = []
        self._issued: list[tuple[Issued, ...]] = []
        self._words: list[list[int]] = []
        self._touched: list[tuple[int, ...]] = []
        self.last = -1

    def see(
        self, cycle: int, region: RegionCode, slot: Slot, newest: int, limit: int, state: State
    ) -> None:
        """See `region.Watch`."""
        self.last = cycle
        if not self._first <= cycle < self._end:
            return
        numbers = self._slots.setdefault(
            region.index,
            {id(one): number for slots in _slots(region) for number, one in enumerate(slots)},
        )
        # that of a loop in the words of the region before it gives way to that one's
        sample = (cycle, region.index, numbers.get(id(slot), 0))
        ops = (*slot.alu, *slot.control, *slot.loads, *slot.stores)
        issued = [
            Issued(op.pe, op.issue.op.value, newest - op.stage)
            for op in ops
            if 0 <= newest - op.stage < limit
        ]
        if self._samples and self._samples[-1][0] == cycle:  # what a loop still does, or has begun
            self._samples[-1] = sample
            self._issued[-1] = tuple(sorted((*self._issued[-1], *issued), key=_by_pe))
            return
        self._samples.append(sample)
        self._issued.append(tuple(sorted(issued, key=_by_pe)))
        self._touched.append(())
        self._words.append([NOTHING if word is None else word for word in state[: self._kept]])

    def touch(self, words: Sequence[int]) -> None:
        """See `region.Watch`."""
        if self._first <= self.last < self._end:
            self._touched[-1] = tuple(words)

    def recording(self, end: int, spans: tuple[RegionSpan, ...], stopped: str | None) -> Recording:
        """All that was seen."""
        samples = np.array(self._samples, np.int64).reshape(-1, 3)
        words = np.array(self._words, np.int64).reshape(len(self._words), self._kept)
        return Recording(
            program=self._program,
            first=self._first,
            end=end,
            cycles=samples[:, 0],
            regions=samples[:, 1],
            slots=samples[:, 2],
            issued=tuple(self._issued),
            words=words,
            touched=tuple(self._touched),
            spans=spans,
            stopped=stopped,
        )
