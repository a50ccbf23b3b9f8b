"""One transfer on its DMA engine: bursts through DRAM channel and NoC (docs/accelerator.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vividc.arch import Accelerator
from vividc.sim.accelerator.bursts import Burst
from vividc.sim.accelerator.clockwork import Clock, Server


@dataclass
class Moved:
    """Bytes at each level.

    `dram_read` and `dram_written` are what DRAM moves, whole granules; `dram_wanted` is what of it
    was asked for. A word that goes to several tiles crosses the NoC once.
    """

    dram_read: int = 0
    dram_written: int = 0
    dram_wanted: int = 0
    noc: int = 0
    scratchpad_in: int = 0
    scratchpad_out: int = 0


class Resources:
    """What the engines share.

    Parameters
    ----------
    take_banks
        Called with (tile, cycles, cycle) when a burst takes a scratchpad's banks.
    """

    def __init__(
        self,
        machine: Accelerator,
        clock: Clock,
        moved: Moved,
        take_banks: Callable[[int, int, int], None],
    ) -> None:
        self.machine = machine
        self.clock = clock
        self.dram = Server(clock)
        self.noc = Server(clock)
        self.moved = moved
        self.take_banks = take_banks


@dataclass
class TransferRun:
    """A transfer that has an engine: from `start` on it asks for one burst after the other.

    Attributes
    ----------
    indices, bursts
        The bursts that read a gather's indices, and those that move the data.
    done
        Called with the bytes moved and the cycle after the last.
    """

    resources: Resources
    engine: int
    tiles: tuple[int, ...]
    writes_dram: bool
    indices: tuple[Burst, ...]
    bursts: tuple[Burst, ...]
    done: Callable[[int, int], None]
    _sent: int = 0
    _arrived: int = 0

    def start(self, cycle: int) -> None:
        """Set the engine up, and begin."""
        ready = cycle + self.resources.machine.dma.setup_cycles
        ask = self._ask_index if self.indices else self._ask
        self.resources.clock.at(ready, ask if self.bursts or self.indices else self._end)

    def _ask_index(self, cycle: int) -> None:
        burst = self.indices[self._sent]
        self.resources.dram.request(cycle, self.engine, burst.dram_cycles, self._index_granted)

    def _index_granted(self, cycle: int) -> None:
        burst = self.indices[self._sent]
        self._read(burst)
        self._sent += 1
        left = cycle + burst.dram_cycles
        if self._sent < len(self.indices):
            self.resources.clock.at(left, self._ask_index)
            return
        # The first row is asked for when the last index is known.
        self._sent = 0
        known = left + self.resources.machine.dram.latency
        self.resources.clock.at(known, self._ask if self.bursts else self._end)

    def _ask(self, cycle: int) -> None:
        burst = self.bursts[self._sent]
        if self.writes_dram:
            self.resources.noc.request(cycle, self.engine, burst.noc_cycles, self._leaves_tile)
        else:
            self.resources.dram.request(cycle, self.engine, burst.dram_cycles, self._leaves_dram)

    def _next(self, cycle: int) -> Burst:
        """The burst that was granted; the following one is asked for in `cycle`."""
        burst = self.bursts[self._sent]
        self._sent += 1
        if self._sent < len(self.bursts):
            self.resources.clock.at(cycle, self._ask)
        return burst

    def _leaves_dram(self, cycle: int) -> None:
        left = cycle + self.bursts[self._sent].dram_cycles
        burst = self._next(left)
        self._read(burst)
        arrives = left + self.resources.machine.dram.latency
        self.resources.clock.at(arrives, lambda now: self._cross(burst, now))

    def _cross(self, burst: Burst, cycle: int) -> None:
        def granted(now: int) -> None:
            self.resources.moved.noc += burst.size
            arrives = now + burst.noc_cycles + self.resources.machine.noc.latency
            self.resources.clock.at(arrives, lambda end: self._reaches_tile(burst, end))

        self.resources.noc.request(cycle, self.engine, burst.noc_cycles, granted)

    def _reaches_tile(self, burst: Burst, cycle: int) -> None:
        self.resources.moved.scratchpad_in += burst.size * len(self.tiles)
        for tile in self.tiles:
            self.resources.take_banks(tile, burst.pad_cycles, cycle)
        self._arrive(cycle)

    def _leaves_tile(self, cycle: int) -> None:
        burst = self._next(cycle + self.bursts[self._sent].noc_cycles)
        moved = self.resources.moved
        moved.noc += burst.size
        moved.scratchpad_out += burst.size
        self.resources.take_banks(self.tiles[0], burst.pad_cycles, cycle)
        arrives = cycle + burst.noc_cycles + self.resources.machine.noc.latency
        self.resources.clock.at(arrives, lambda now: self._to_dram(burst, now))

    def _to_dram(self, burst: Burst, cycle: int) -> None:
        def granted(now: int) -> None:
            self.resources.moved.dram_written += burst.dram_bytes
            self.resources.moved.dram_wanted += burst.size
            self.resources.clock.at(now + burst.dram_cycles, self._arrive)

        self.resources.dram.request(cycle, self.engine, burst.dram_cycles, granted)

    def _read(self, burst: Burst) -> None:
        self.resources.moved.dram_read += burst.dram_bytes
        self.resources.moved.dram_wanted += burst.size

    def _arrive(self, cycle: int) -> None:
        self._arrived += 1
        if self._arrived == len(self.bursts):
            self._end(cycle)

    def _end(self, cycle: int) -> None:
        self.done(sum(burst.size for burst in self.bursts), cycle)
