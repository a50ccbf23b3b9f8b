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

_SHARED = 4
"""Times the cycles of DRAM's channel that a transfer takes while all engines are at work: a tile
with one place of blocks computes nothing meanwhile (blur of 1024x1024: 3 to 4).
"""
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
        Cycles of the tile with most runs.
    configuring
        Cycles in which all tiles get the program.
    """

    plan: BlockPlan
    channel: int
    ends: int
    computing: int
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
        return Chosen(BlockPlan((), (), {}), 0, 0, 0, 0)
    expected: list[tuple[float, Choice]] = []
    least = float("inf")
    for choice in choices:
        if choice.channel >= least or len(expected) == _MOST_RUNS:
            break
        cycles = max(choice.channel, _computing(launch, choice))
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
    return Chosen(
        plan,
        round(choice.moved),
        round(choice.channel - choice.moved),
        round(_computing(launch, choice)),
        entries // machine.configuration.entries_per_cycle,
    )


def _computing(launch: NestLaunch, choice: Choice) -> float:
    """Cycles of the tile with most runs, with what it waits for transfers of its own."""
    count, block = middle_block(launch, choice)
    moved = choice.channel / count  # the scratchpad's banks are taken for as long as the channel
    run = _run_cycles(launch, block) + moved * (_SHARED if choice.places == 1 else 1)
    return run * -(-count // len(launch.machine.tiles))


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
