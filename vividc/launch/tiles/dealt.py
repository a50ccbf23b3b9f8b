"""To which tile each chunk of a loop goes: to the one that is predicted to be done with it first.

Tiles get their program one after the other, so that a small launch is done before the last of them
has it. What a tile computes, and in which chunks, does not depend on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vividc.launch.steps import Configure
from vividc.launch.tiles.chunks import Chunk, Cut, Plan

_PROBED = (2, 4)
"""Behind which part of the chunks one is run to time it. Others are taken to last as long as the
slower of both: rather too many tiles than too few.
"""


@dataclass(frozen=True, slots=True)
class Costs:
    """What chunks cost, in cycles.

    Attributes
    ----------
    configuring
        Until one more tile has the program.
    run
        Of a chunk on its tile, with the launch words.
    moved_in, moved_out
        Of DRAM's channel, for each chunk.
    latency, latency_out
        Of a transfer from DRAM, besides, and of one to DRAM.
    before
        Of the channel, for what all chunks read.
    """

    configuring: int
    run: int
    moved_in: Sequence[int]
    moved_out: Sequence[int]
    latency: int
    latency_out: int
    before: int


@dataclass(frozen=True, slots=True)
class Dealt:
    """The tile of each chunk, and in which cycle the launch is predicted to be done."""

    tiles: tuple[int, ...]
    cycles: int


def probed(plan: Plan) -> list[int]:
    """Numbers of chunks that stand for all."""
    return [len(plan.chunks) // part for part in _PROBED]


def costs_of(cut: Cut, plan: Plan, words: int, run: int) -> Costs:
    """What the chunks of a plan cost.

    Parameters
    ----------
    words
        Launch words of a run.
    run
        Cycles of a run.
    """
    machine, program = cut.machine, cut.program
    entries = Configure((0,), (program,)).entries
    own = {local.name for local in program.locals}

    def moved(chunk: Chunk, *, back: bool) -> int:
        total = 0
        for name, touch in chunk.touches.items():
            part = touch.stores if back else touch.hull
            skipped = not back and (name in chunk.overwritten or name in plan.resident)
            if part is not None and name not in own and not skipped:
                total += machine.dram.cycles(*part)
        return total

    dma, dram = machine.dma, machine.dram
    return Costs(
        -(-entries // machine.configuration.entries_per_cycle),
        words + run,
        [moved(chunk, back=False) for chunk in plan.chunks],
        [moved(chunk, back=True) for chunk in plan.chunks],
        dma.setup_cycles + dram.latency + machine.noc.latency,
        dma.setup_cycles + machine.noc.latency,
        sum(machine.dram.cycles(*part) for part in plan.resident.values()),
    )


@dataclass
class _Tile:
    """When a tile is free, and each of its places."""

    free: int
    places: list[int]
    turn: int = 0


@dataclass
class _Clock:
    """Chunks in their order, each on the tile that is done with it first."""

    costs: Costs
    copies: int
    most: int
    tiles: list[_Tile] = field(default_factory=list)
    busy: int = 0
    """Of the channel, so far."""

    def place(self, number: int) -> int:
        """The tile of a chunk."""
        if len(self.tiles) < self.most:
            configured = (len(self.tiles) + 1) * self.costs.configuring
            self.tiles.append(_Tile(configured, [0] * self.copies))
        ends = [self._end(number, tile) for tile in self.tiles]
        ready = [tile.places[tile.turn % self.copies] for tile in self.tiles]
        best = min(range(len(ends)), key=lambda tile: (ends[tile], ready[tile]))
        if best < len(self.tiles) - 1 and not self.tiles[-1].turn:
            self.tiles.pop()
        tile, costs = self.tiles[best], self.costs
        tile.free = ends[best]
        self.busy += costs.moved_in[number] + costs.moved_out[number]
        done = tile.free
        if costs.moved_out[number]:
            asked = max(
                done + costs.latency_out, self.busy + costs.before - costs.moved_out[number]
            )
            done = asked + costs.moved_out[number]
        tile.places[tile.turn % self.copies] = done
        tile.turn += 1
        return best

    def _end(self, number: int, tile: _Tile) -> int:
        costs = self.costs
        ready = tile.places[tile.turn % self.copies]
        moved = max(
            ready + costs.moved_in[number], self.busy + costs.before + costs.moved_in[number]
        )
        return max(tile.free, moved + costs.latency) + costs.run


def dealt(costs: Costs, copies: int, tiles: int) -> Dealt:
    """Deal chunks out in their order.

    Parameters
    ----------
    copies
        Places of slices in each scratchpad.
    tiles
        How many there are.
    """
    clock = _Clock(costs, copies, tiles)
    order = tuple(clock.place(number) for number in range(len(costs.moved_in)))
    last = max((place for tile in clock.tiles for place in tile.places), default=0)
    return Dealt(order, max(last, clock.busy + costs.before))
