"""All that a native run changes, in arrays that the machine code works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vividc.program import Program
from vividc.sim.engine import Launch
from vividc.sim.native.layout import EXTENT_WORDS, MEMORY_SLACK_BYTES, Layout, Place

_SLACK = MEMORY_SLACK_BYTES // 4


@dataclass
class MachineState:
    """A tile between two regions, or in a suspended loop.

    Attributes
    ----------
    context
        int64: see `layout`.
    constants
        Constant stores, uint32, one PE behind the other.
    memory
        The scratchpad and some slack, uint32.
    """

    context: NDArray[np.int64]
    constants: NDArray[np.uint32]
    memory: NDArray[np.uint32]

    @property
    def scratchpad(self) -> NDArray[np.uint32]:
        """A view of the scratchpad."""
        return self.memory[:-_SLACK]

    @property
    def now(self) -> int:
        """Cycles run so far."""
        place = Place.NOW if self.context[Place.RESUME] else Place.CYCLE
        return int(self.context[place])

    def copy(self) -> MachineState:
        """A snapshot."""
        return MachineState(self.context.copy(), self.constants.copy(), self.memory.copy())


def initial_state(
    program: Program, layout: Layout, context_words: int, launch: Launch
) -> MachineState:
    """The tile as the host leaves it at a launch."""
    context = np.zeros(context_words, np.int64)
    context[Place.CYCLE_LIMIT] = launch.cycle_limit
    everywhere = (0, program.fabric.scratchpad.size_bytes)
    for name, number in layout.arrays.items():
        first, end = launch.extents.get(name, everywhere)
        bounds = (max(0, end - first - width + 1) for width in (1, 2, 4))
        place = layout.extents + EXTENT_WORDS * number
        context[place : place + EXTENT_WORDS] = (first, *bounds)
    constants = np.where(program.images_set, program.images, 0).astype(np.uint32).reshape(-1)
    for row in program.launch:
        constants[row.pe * layout.entries + row.entry] = launch.inputs[row.key]
    memory = np.zeros(launch.memory.size + _SLACK, np.uint32)
    memory[:-_SLACK] = launch.memory
    return MachineState(context, constants, memory)
