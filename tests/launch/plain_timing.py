"""The timing of jobs in plain Python, with a function for each thing that happens: the witness of
`vividc.launch.timing`, written from docs/accelerator.md.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count

import numpy as np

from vividc.arch import Accelerator
from vividc.launch import Event
from vividc.launch.functional import Outcome
from vividc.launch.steps import Configure, Execute, Pieces, Step, Transfer
from vividc.program import WORD_BYTES

Action = Callable[[int], None]
CAUSES = {Transfer: "dma", Configure: "configuration", Execute: "dependency"}


class Clock:
    """Calls actions in order of (cycle, rank, order of scheduling)."""

    def __init__(self) -> None:
        self._heap: list[tuple[int, int, int, Action]] = []
        self._count = 0

    def at(self, cycle: int, action: Action, rank: int = 0) -> None:
        heapq.heappush(self._heap, (cycle, rank, self._count, action))
        self._count += 1

    def run(self) -> None:
        while self._heap:
            cycle, _, _, action = heapq.heappop(self._heap)
            action(cycle)


class Server:
    """One at a time: the oldest."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: list[tuple[int, int, int, Action]] = []
        self._free_from = self._count = self.busy = 0

    def request(self, cycle: int, age: int, holds: int, granted: Action) -> None:
        heapq.heappush(self._waiting, (age, self._count, holds, granted))
        self._count += 1
        self._clock.at(max(cycle, self._free_from), self._grant, rank=1)

    def _grant(self, cycle: int) -> None:
        if not self._waiting or cycle < self._free_from:
            return
        _, _, holds, granted = heapq.heappop(self._waiting)
        self._free_from = cycle + holds
        self.busy += holds
        if self._waiting:
            self._clock.at(self._free_from, self._grant, rank=1)
        granted(cycle)


@dataclass
class Burst:
    size: int
    dram_bytes: int
    dram_cycles: int
    noc_cycles: int
    pad_cycles: int


def bursts(machine: Accelerator, pieces: Pieces | None, line: int) -> Iterator[Burst]:
    length, granule = machine.dma.burst_bytes, machine.dram.granule_bytes
    for first, size in () if pieces is None else pieces.spans.tolist():
        start, end = first, first + size
        while start < end:
            stop = min(end, (start // length + 1) * length)
            moved = -(-stop // granule) * granule - start // granule * granule
            pad = -(-(stop - start) // line)
            noc = -(-(stop - start) // machine.noc.bytes_per_cycle)
            channel = -(-moved // machine.dram.bytes_per_cycle)
            yield Burst(stop - start, moved, channel, noc, pad)
            start = stop


class TransferRun:
    """A transfer that has an engine."""

    def __init__(self, job: PlainTiming, engine: int, number: int, step: Transfer) -> None:
        machine = job.machine
        banks = min(machine.units[tile].scratchpad.banks for tile in step.tiles)
        line = max(WORD_BYTES, WORD_BYTES * (WORD_BYTES * banks // step.pitch))
        is_chosen = step.kind in ("gather", "scatter") or step.count_at is not None
        pieces = job.outcome.chosen[number] if is_chosen else step.pieces
        self.job, self.engine, self.number, self.step = job, engine, number, step
        self.age = next(job.ages)
        where = step.index_pieces
        if step.listed is not None:
            size = WORD_BYTES * (1 + job.outcome.listed[number])
            where = Pieces(0, np.array([(step.listed.address, size)]))
        if step.count_at is not None:
            where = Pieces(0, np.array([(step.count_at, WORD_BYTES)]))
        self.is_told_by_tile = step.listed is not None or step.count_at is not None
        self.indices = list(bursts(machine, where, line))
        self.bursts = list(bursts(machine, pieces, line))
        self.sent = self.arrived = 0

    def start(self, cycle: int) -> None:
        ask = self.ask_index if self.indices else self.ask
        ready = cycle + self.job.machine.dma.setup_cycles
        self.job.clock.at(ready, ask if self.bursts or self.indices else self.end)

    def ask_index(self, cycle: int) -> None:
        if self.is_told_by_tile:
            holds = self.indices[self.sent].noc_cycles
            self.job.noc.request(cycle, self.age, holds, self.list_granted)
            return
        holds = self.indices[self.sent].dram_cycles
        self.job.dram.request(cycle, self.age, holds, self.index_granted)

    def index_granted(self, cycle: int) -> None:
        burst = self.indices[self.sent]
        self.read(burst)
        self.sent += 1
        left = cycle + burst.dram_cycles
        if self.sent < len(self.indices):
            self.job.clock.at(left, self.ask_index)
            return
        self.sent = 0
        known = left + self.job.machine.dram.latency
        self.job.clock.at(known, self.ask if self.bursts else self.end)

    def list_granted(self, cycle: int) -> None:
        burst, machine = self.indices[self.sent], self.job.machine
        self.job.moved["noc"] += burst.size
        self.job.moved["scratchpad_out"] += burst.size
        self.job.take_banks(self.step.tiles[0], burst.pad_cycles, cycle)
        self.sent += 1
        passed = self.through_ports(burst, cycle)
        if self.sent < len(self.indices):
            self.job.clock.at(passed - machine.noc.latency, self.ask_index)
            return
        self.sent = 0
        self.job.clock.at(passed, self.ask if self.bursts else self.end)

    def ask(self, cycle: int) -> None:
        burst = self.bursts[self.sent]
        if self.step.kind in ("move out", "scatter"):
            self.job.noc.request(cycle, self.age, burst.noc_cycles, self.leaves_tile)
        else:
            self.job.dram.request(cycle, self.age, burst.dram_cycles, self.leaves_dram)

    def next(self, cycle: int) -> Burst:
        self.sent += 1
        if self.sent < len(self.bursts):
            self.job.clock.at(cycle, self.ask)
        return self.bursts[self.sent - 1]

    def leaves_dram(self, cycle: int) -> None:
        left = cycle + self.bursts[self.sent].dram_cycles
        burst = self.next(left)
        self.read(burst)
        self.job.clock.at(left + self.job.machine.dram.latency, partial(self.cross, burst))

    def cross(self, burst: Burst, cycle: int) -> None:
        def granted(now: int) -> None:
            self.job.moved["noc"] += burst.size
            arrives = self.through_ports(burst, now)
            self.job.clock.at(arrives, partial(self.reaches_tile, burst))

        self.job.noc.request(cycle, self.age, burst.noc_cycles, granted)

    def through_ports(self, burst: Burst, granted: int) -> int:
        """When the last word has passed the ports: all of them take the burst together."""
        free = [self.job.ports[tile] for tile in self.step.tiles]
        begins = max(granted + self.job.machine.noc.latency, *free)
        ends = begins + max(burst.noc_cycles, burst.pad_cycles)
        self.job.ports.update(dict.fromkeys(self.step.tiles, ends))
        return ends

    def reaches_tile(self, burst: Burst, cycle: int) -> None:
        for tile in self.step.tiles:
            self.job.moved["scratchpad_in"] += burst.size
            self.job.take_banks(tile, burst.pad_cycles, cycle)
        self.arrive(cycle)

    def leaves_tile(self, cycle: int) -> None:
        arrives = self.through_ports(self.bursts[self.sent], cycle)
        burst = self.next(arrives - self.job.machine.noc.latency)
        self.job.moved["noc"] += burst.size
        self.job.moved["scratchpad_out"] += burst.size
        self.job.take_banks(self.step.tiles[0], burst.pad_cycles, cycle)
        self.job.clock.at(arrives, partial(self.to_dram, burst))

    def to_dram(self, burst: Burst, cycle: int) -> None:
        def granted(now: int) -> None:
            self.job.moved["dram_written"] += burst.dram_bytes
            self.job.moved["dram_wanted"] += burst.size
            self.job.clock.at(now + burst.dram_cycles, self.arrive)

        self.job.dram.request(cycle, self.age, burst.dram_cycles, granted)

    def read(self, burst: Burst) -> None:
        self.job.moved["dram_read"] += burst.dram_bytes
        self.job.moved["dram_wanted"] += burst.size

    def arrive(self, cycle: int) -> None:
        self.arrived += 1
        if self.arrived == len(self.bursts):
            self.end(cycle)

    def end(self, cycle: int) -> None:
        size = sum(burst.size for burst in self.bursts)
        self.job.transferred(self.engine, self.number, size, cycle)


class Stream:
    """The programs that are loaded, one after the other."""

    def __init__(self, machine: Accelerator, steps: Sequence[Step]) -> None:
        self.machine = machine
        self.ready: set[int] = set()
        self.started: set[tuple[int, int]] = set()
        self.is_loading = False
        self.runs_left = Counter(
            (step.configured_by, step.tile) for step in steps if isinstance(step, Execute)
        )
        held: dict[int, int] = {}
        self.replaced: dict[int, list[tuple[int, int]]] = {}
        for number, step in enumerate(steps):
            if isinstance(step, Configure):
                units = set(step.tiles).union(*(machine.sharing[tile] for tile in step.tiles))
                self.replaced[number] = [(held.pop(unit), unit) for unit in units if unit in held]
                held.update(dict.fromkeys(step.tiles, number))

    def take(self) -> int | None:
        for number in sorted(self.ready) if not self.is_loading else ():
            if all(self.is_free(held) for held in self.replaced[number]):
                self.ready.remove(number)
                self.is_loading = True
                return number
        return None

    def is_free(self, held: tuple[int, int]) -> bool:
        has_shadow = self.machine.configuration.double_buffered
        return self.runs_left[held] == 0 or (has_shadow and held in self.started)


class PlainTiming:
    """A job's timing; results are attributes after `run`."""

    def __init__(
        self,
        machine: Accelerator,
        steps: Sequence[Step],
        waits: Sequence[tuple[int, ...]],
        outcome: Outcome,
    ) -> None:
        self.machine, self.steps, self.waits, self.outcome = machine, steps, waits, outcome
        self.clock = Clock()
        self.dram, self.noc = Server(self.clock), Server(self.clock)
        self.stream = Stream(machine, steps)
        self.moved: Counter[str] = Counter()
        self.spans = [[0, 0, 0] for _ in steps]
        self.events: list[Event] = []
        self.left = [len(before) for before in waits]
        self.engines = list(range(machine.dma.engines))
        self.ages = count()
        self.queue: list[tuple[int, int]] = []
        units = range(len(machine.units))
        self.ports = dict.fromkeys(units, 0)
        self.stalls: list[Counter[str]] = [Counter() for _ in units]
        self.free_from = [0 for _ in units]
        self.running: list[int | None] = [None for _ in units]
        self.issue_from, self.stop = [0 for _ in units], [0 for _ in units]

    def run(self) -> None:
        for number, left in enumerate(self.left):
            if left == 0:
                self.clock.at(0, partial(self.ready, number))
        self.clock.run()
        self.events.sort(key=lambda e: (e.start, e.unit, e.index, e.step))

    def ready(self, number: int, cycle: int) -> None:
        self.spans[number][0] = cycle
        step = self.steps[number]
        if isinstance(step, Transfer):
            heapq.heappush(self.queue, (cycle, number))
            self.clock.at(cycle, self.start_transfers, rank=1)
        elif isinstance(step, Configure):
            self.stream.ready.add(number)
            self.clock.at(cycle, self.start_stream, rank=1)
        else:
            self.start_run(number, step, cycle)

    def finish(self, number: int, cycle: int) -> None:
        self.spans[number][2] = cycle
        for follower, before in enumerate(self.waits):
            if number in before:
                self.left[follower] -= 1
                if self.left[follower] == 0:
                    self.ready(follower, cycle)

    def start_stream(self, cycle: int) -> None:
        number = self.stream.take()
        if number is not None:
            step = self.steps[number]
            self.spans[number][1] = cycle
            end = cycle - -step.entries // self.machine.configuration.entries_per_cycle
            name, tiles = step.programs[0].name, step.tiles
            self.events.append(
                Event("configuration", 0, "configure", number, cycle, end, 0, name, tiles)
            )
            self.clock.at(end, partial(self.configured, number))

    def configured(self, number: int, cycle: int) -> None:
        self.stream.is_loading = False
        self.clock.at(cycle, self.start_stream, rank=1)
        self.finish(number, cycle)

    def start_transfers(self, cycle: int) -> None:
        while self.queue and self.engines:
            _, number = heapq.heappop(self.queue)
            self.spans[number][1] = cycle
            engine = heapq.heappop(self.engines)
            TransferRun(self, engine, number, self.steps[number]).start(cycle)

    def transferred(self, engine: int, number: int, size: int, cycle: int) -> None:
        step, start = self.steps[number], self.spans[number][1]
        self.events.append(
            Event("dma", engine, step.kind, number, start, cycle, size, "", step.tiles)
        )
        heapq.heappush(self.engines, engine)
        self.clock.at(cycle, self.start_transfers, rank=1)
        self.finish(number, cycle)

    def take_banks(self, tile: int, cycles: int, cycle: int) -> None:
        if self.running[tile] is not None and self.issue_from[tile] <= cycle < self.stop[tile]:
            self.stalls[tile]["scratchpad"] += cycles
            self.stop_at(tile, self.stop[tile] + cycles)

    def start_run(self, number: int, step: Execute, cycle: int) -> None:
        tile, wait = step.tile, cycle - self.free_from[step.tile]
        if wait > 0:
            last = max(self.waits[number], key=lambda n: (self.spans[n][2], n))
            self.stalls[tile][CAUSES[type(self.steps[last])]] += wait
        self.spans[number][1] = cycle
        self.running[tile] = number
        self.stalls[tile]["launch"] += step.launch_words
        self.issue_from[tile] = cycle + step.launch_words
        self.stream.started.add((step.configured_by, tile))
        self.clock.at(cycle, self.start_stream, rank=1)
        self.stop_at(tile, self.issue_from[tile] + self.outcome.runs[number].cycles)

    def stop_at(self, tile: int, cycle: int) -> None:
        self.stop[tile] = cycle
        self.clock.at(cycle, partial(self.end_run, tile))

    def end_run(self, tile: int, cycle: int) -> None:
        number = self.running[tile]
        if number is None or cycle != self.stop[tile]:
            return
        step, start = self.steps[number], self.spans[number][1]
        self.running[tile], self.free_from[tile] = None, cycle
        name = step.program.name
        self.events.append(Event("tile", tile, "run", number, start, cycle, 0, name, (tile,)))
        self.stream.runs_left[step.configured_by, tile] -= 1
        self.clock.at(cycle, self.start_stream, rank=1)
        self.finish(number, cycle)
