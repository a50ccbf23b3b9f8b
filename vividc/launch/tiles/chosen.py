"""Which way of cutting a nest is fastest: the cycles of a launch are predicted from what its blocks
move, and from a run of one of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.errors import SimulationError
from vividc.launch.tiles.blocks import (
    BlockPlan,
    Choice,
    NestLaunch,
    block_choices,
    middle_block,
    plan_of,
    refusal,
)
from vividc.launch.tiles.placed import Placed
from vividc.machine.words import WORD_BYTES
from vividc.sim.engine import Launch
from vividc.sim.footprint.boxes import Block
from vividc.sim.run import CYCLE_LIMIT
from vividc.sim.tile import shared_tile

_MOST_RUNS = 16
"""Ways to cut a nest that are tried: those that move least."""
_MOST_PLANS = 4
"""Of them, those that are planned as a whole to see whether they fit."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """A plan, and what is expected of it.

    Attributes
    ----------
    channel
        Cycles of DRAM's channel.
    ends
        Cycles in which it waits for the first and the last blocks, where nothing comes before and
        after this nest.
    computing
        Cycles of each tile, if runs are shared evenly.
    uneven
        By how many more the tile with most runs takes.
    configuring
        Cycles in which all tiles get the program.
    """

    plan: BlockPlan
    channel: int
    ends: int
    computing: int
    uneven: int
    configuring: int


def chosen(launch: NestLaunch) -> Chosen:
    """The plan that is expected to be done first.

    Raises
    ------
    ArgumentError
        Not even a single iteration fits a scratchpad.
    """
    choices = block_choices(launch)
    if not choices:
        first, last = launch.bounds
        if first < last:
            raise refusal(launch)
        return Chosen(BlockPlan((), (), {}), 0, 0, 0, 0, 0)
    expected: list[tuple[float, Choice]] = []
    least = float("inf")
    for choice in choices:
        if choice.channel >= least or len(expected) == _MOST_RUNS:
            break
        cycles = max(choice.channel, sum(_computing(launch, choice)))
        expected.append((cycles, choice))
        least = min(least, cycles)
    ranked = [choice for _, choice in sorted(expected)]
    for choice in (*ranked[:_MOST_PLANS], *choices):
        plan = plan_of(launch, choice)
        if plan is not None:
            return _chosen(launch, choice, plan)
    raise refusal(launch)


def _chosen(launch: NestLaunch, choice: Choice, plan: BlockPlan) -> Chosen:
    machine = launch.machine
    tiles = min(len(machine.tiles), len(plan.blocks))
    entries = tiles * len(launch.program.fabric.pes) * len(launch.program.words)
    computing, uneven = _computing(launch, choice)
    return Chosen(
        plan,
        round(choice.moved),
        round(choice.channel - choice.moved),
        round(computing),
        round(uneven),
        entries // machine.configuration.entries_per_cycle,
    )


def _computing(launch: NestLaunch, choice: Choice) -> tuple[float, float]:
    """Cycles of each tile, with what it waits for transfers of its own, if runs are shared evenly;
    and by how many more the tile with most runs takes.
    """
    count, block = middle_block(launch, choice)
    moved = choice.moved / count  # the scratchpad's banks are taken for as long as the channel
    run, tiles = _run_cycles(launch, block), len(launch.machine.tiles)
    if choice.places == 1:  # nothing is computed meanwhile
        moved = _waited(run, moved, min(tiles, count))
    even = (run + moved) * count / tiles
    return even, (run + moved) * -(-count // tiles) - even


def _waited(run: float, moved: float, tiles: int) -> float:
    """Cycles from when a tile asks for a transfer, which takes DRAM's channel `moved` cycles, until
    it has it: as many tiles ask after each run, and one waits for another (mean values of a closed
    queue; Reiser and Lavenberg, 1980).
    """
    asking = waited = 0.0
    for number in range(1, tiles + 1):
        waited = moved * (1 + asking)
        asking = number * waited / (run + waited) if waited else 0.0
    return waited


def _run_cycles(launch: NestLaunch, block: Block) -> int:
    """Cycles of a block's run with zeros in its arrays; 0 if it fails with these."""
    placed = Placed(launch, 0)
    for name, window in launch.windows(block).items():
        placed.add(name, window)
    extents = placed.extents()
    size = launch.program.fabric.scratchpad.size_bytes
    memory = np.zeros(max(size, placed.end) // WORD_BYTES, np.uint32)
    for local in launch.program.locals:
        local.fill(memory, extents[local.name][0])
    given = Launch(memory, placed.inputs(block), CYCLE_LIMIT, extents)
    try:
        return shared_tile(launch.program).run(given).cycles
    except SimulationError:
        return 0
