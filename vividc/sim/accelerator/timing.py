"""When each step of a job happens: an event simulation of docs/accelerator.md.

What a job computes is known before; here only cycles are counted.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from vividc.arch import Accelerator
from vividc.errors import InternalError
from vividc.program import WORD_BYTES
from vividc.sim.accelerator.bursts import bursts
from vividc.sim.accelerator.clockwork import Clock
from vividc.sim.accelerator.event import Event
from vividc.sim.accelerator.functional import Outcome
from vividc.sim.accelerator.steps import Configure, Execute, Step, Transfer
from vividc.sim.accelerator.stream import Stream
from vividc.sim.accelerator.transfer import Moved, Resources, TransferRun


@dataclass
class Span:
    """When a step ran. `ready`: when all it waits for was done."""

    ready: int = 0
    start: int = 0
    end: int = 0


@dataclass
class TileClock:
    """The state of a tile, and where its cycles went.

    `stalls`: by cause, "dma": waits for transfers; "configuration": bubbles of a switch;
    "dependency": waits for other tiles; "launch": the controller writes launch words;
    "scratchpad": DMA has the banks.
    """

    free_from: int = 0
    running: int | None = None
    issue_from: int = 0
    end: int = 0
    version: int = 0
    stalls: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ("dma", "configuration", "dependency", "launch", "scratchpad"), 0
        )
    )


@dataclass(frozen=True)
class Timing:
    """The outcome: a span for each step, what the tiles waited for, bytes, events."""

    cycles: int
    spans: tuple[Span, ...]
    tiles: tuple[TileClock, ...]
    moved: Moved
    events: tuple[Event, ...]
    busy: Mapping[str, int]


def schedule(
    accelerator: Accelerator,
    steps: Sequence[Step],
    waits: Sequence[tuple[int, ...]],
    outcome: Outcome,
) -> Timing:
    """Simulate the job's timing.

    Parameters
    ----------
    waits
        Steps that each step waits for.
    outcome
        Cycles of the runs, and the rows that gathers moved.
    """
    return _Simulation(accelerator, steps, waits, outcome).run()


class _Simulation:
    def __init__(
        self,
        accelerator: Accelerator,
        steps: Sequence[Step],
        waits: Sequence[tuple[int, ...]],
        outcome: Outcome,
    ) -> None:
        self._machine = accelerator
        self._steps = steps
        self._waits = waits
        self._outcome = outcome
        self._clock = Clock()
        self._moved = Moved()
        self._resources = Resources(accelerator, self._clock, self._moved, self._take_banks)
        self._spans = [Span() for _ in steps]
        self._tiles = [TileClock() for _ in accelerator.units]
        self._events: list[Event] = []
        self._engines = list(range(accelerator.dma.engines))
        self._queue: list[tuple[int, int]] = []
        self._left = [len(before) for before in waits]
        self._followers: list[list[int]] = [[] for _ in steps]
        for number, before in enumerate(waits):
            for other in before:
                self._followers[other].append(number)
        self._stream = Stream(accelerator.configuration, steps, accelerator.sharing)

    def run(self) -> Timing:
        for number, left in enumerate(self._left):
            if left == 0:
                self._clock.at(0, partial(self._ready, number))
        self._clock.run()
        if any(self._left):
            raise InternalError("a launch graph came to a standstill")
        cycles = max((span.end for span in self._spans), default=0)
        events = sorted(self._events, key=lambda e: (e.start, e.unit, e.index, e.step))
        busy = {
            "dram": self._resources.dram.busy_cycles,
            "noc": self._resources.noc.busy_cycles,
        }
        return Timing(
            cycles, tuple(self._spans), tuple(self._tiles), self._moved, tuple(events), busy
        )

    def _ready(self, number: int, cycle: int) -> None:
        self._spans[number].ready = cycle
        step = self._steps[number]
        if isinstance(step, Transfer):
            heapq.heappush(self._queue, (cycle, number))
            self._clock.at(cycle, self._start_transfers, rank=1)
        elif isinstance(step, Configure):
            self._stream.ready(number)
            self._clock.at(cycle, self._start_stream, rank=1)
        else:
            self._start_run(number, step, cycle)

    def _finish(self, number: int, cycle: int) -> None:
        self._spans[number].end = cycle
        for follower in self._followers[number]:
            self._left[follower] -= 1
            if self._left[follower] == 0:
                self._ready(follower, cycle)

    def _start_stream(self, cycle: int) -> None:
        number = self._stream.take()
        if number is None:
            return
        step = self._steps[number]
        assert isinstance(step, Configure)
        self._spans[number].start = cycle
        end = cycle + self._stream.cycles(step)
        name = step.programs[0].name
        self._events.append(
            Event(
                "configuration", 0, "configure", number, cycle, end, program=name, tiles=step.tiles
            )
        )
        self._clock.at(end, lambda cycle: self._configured(number, cycle))

    def _configured(self, number: int, cycle: int) -> None:
        self._stream.loaded()
        self._clock.at(cycle, self._start_stream, rank=1)
        self._finish(number, cycle)

    # Transfers

    def _start_transfers(self, cycle: int) -> None:
        while self._queue and self._engines:
            _, number = heapq.heappop(self._queue)
            engine = heapq.heappop(self._engines)
            step = self._steps[number]
            assert isinstance(step, Transfer)
            self._spans[number].start = cycle
            self._transfer(engine, number, step).start(cycle)

    def _transfer(self, engine: int, number: int, step: Transfer) -> TransferRun:
        machine = self._machine
        banks = min(machine.units[tile].scratchpad.banks for tile in step.tiles)
        line = max(WORD_BYTES, WORD_BYTES * (WORD_BYTES * banks // step.pitch))
        pieces = self._outcome.gathered[number] if step.kind == "gather" else step.pieces
        return TransferRun(
            resources=self._resources,
            engine=engine,
            tiles=step.tiles,
            writes_dram=step.kind == "move out",
            indices=tuple(bursts(machine, step.index_pieces, line)),
            bursts=tuple(bursts(machine, pieces, line)),
            done=lambda size, cycle: self._transferred(engine, number, size, cycle),
        )

    def _transferred(self, engine: int, number: int, size: int, cycle: int) -> None:
        """A transfer is complete."""
        step, span = self._steps[number], self._spans[number]
        assert isinstance(step, Transfer)
        event = Event("dma", engine, step.kind, number, span.start, cycle, size, tiles=step.tiles)
        self._events.append(event)
        heapq.heappush(self._engines, engine)
        self._clock.at(cycle, self._start_transfers, rank=1)
        self._finish(number, cycle)

    def _take_banks(self, tile: int, cycles: int, cycle: int) -> None:
        """DMA has the banks of a tile for some cycles: a program that runs there stands still."""
        state = self._tiles[tile]
        if state.running is None or not state.issue_from <= cycle < state.end:
            return
        state.stalls["scratchpad"] += cycles
        self._end_run_at(tile, state.end + cycles)

    # Runs

    def _start_run(self, number: int, step: Execute, cycle: int) -> None:
        state = self._tiles[step.tile]
        self._charge_wait(number, state, cycle)
        span = self._spans[number]
        span.start = cycle
        state.running = number
        state.stalls["launch"] += step.launch_words
        state.issue_from = cycle + step.launch_words
        self._stream.started(step)
        self._clock.at(cycle, self._start_stream, rank=1)
        run = self._outcome.runs[number]
        self._end_run_at(step.tile, state.issue_from + run.cycles)

    def _charge_wait(self, number: int, state: TileClock, cycle: int) -> None:
        """The whole wait is charged to what ended last."""
        wait = cycle - state.free_from
        if wait <= 0:
            return
        last = max(self._waits[number], key=lambda n: (self._spans[n].end, n))
        step = self._steps[last]
        cause = {Transfer: "dma", Configure: "configuration", Execute: "dependency"}[type(step)]
        state.stalls[cause] += wait

    def _end_run_at(self, tile: int, end: int) -> None:
        state = self._tiles[tile]
        state.end = end
        state.version += 1
        version = state.version
        self._clock.at(end, lambda cycle: self._end_run(tile, version, cycle), rank=0)

    def _end_run(self, tile: int, version: int, cycle: int) -> None:
        state = self._tiles[tile]
        if version != state.version or state.running is None:
            return
        number = state.running
        step = self._steps[number]
        assert isinstance(step, Execute)
        state.running = None
        state.free_from = cycle
        start = self._spans[number].start
        name = step.program.name
        self._events.append(
            Event("tile", tile, "run", number, start, cycle, program=name, tiles=(tile,))
        )
        self._stream.ended(step)
        self._clock.at(cycle, self._start_stream, rank=1)
        self._finish(number, cycle)
