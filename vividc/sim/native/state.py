"""The mutable state of a native run, in arrays that the machine code works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vividc.program import Home, Program
from vividc.program.dataflow import Constant
from vividc.sim.engine import Launch
from vividc.sim.native.plan.layout import BITS, MEMORY_SLACK_BYTES, Layout, Place

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
    def pointers(self) -> tuple[int, int, int]:
        """Addresses of the arrays."""
        return self.context.ctypes.data, self.constants.ctypes.data, self.memory.ctypes.data

    @property
    def now(self) -> int:
        """Cycles run so far."""
        place = Place.NOW if self.context[Place.RESUME] else Place.CYCLE
        return int(self.context[place])

    def is_set(self, layout: Layout, bit: int) -> bool:
        """Whether a constant-store entry that no launch sets has been written."""
        return bool(int(self.context[layout.valid_word(bit)]) >> bit % BITS & 1)

    def word_at(self, layout: Layout, home: Home) -> int | None:
        """A constant-store entry; None: nothing was written there."""
        constant = Constant(home.pe, home.entry)
        bit = layout.bits.get(constant)
        if bit is not None and not self.is_set(layout, bit):
            return None
        return int(self.constants[layout.cell(constant)])

    def copy(self) -> MachineState:
        """A snapshot."""
        return MachineState(self.context.copy(), self.constants.copy(), self.memory.copy())


def image(program: Program) -> NDArray[np.uint32]:
    """Constant stores before the launch words."""
    return np.where(program.images_set, program.images, 0).astype(np.uint32).reshape(-1)


def initial_state(
    program: Program,
    layout: Layout,
    blank: tuple[int, NDArray[np.uint32]],
    launch: Launch,
) -> MachineState:
    """The tile as the host leaves it at a launch.

    Parameters
    ----------
    blank
        Words of the context, and the image of the constant stores.
    """
    context = np.zeros(blank[0], np.int64)
    context[Place.CYCLE_LIMIT] = launch.cycle_limit
    everywhere = (0, program.fabric.scratchpad.size_bytes)
    words: list[int] = []
    for name in layout.arrays:
        first, end = launch.extents.get(name, everywhere)
        size = end - first
        words += (first, size, max(0, size - 1), max(0, size - 3))
    context[layout.extents : layout.extents + len(words)] = words
    constants = blank[1].copy()
    places = [row.pe * layout.entries + row.entry for row in program.launch]
    constants[places] = [launch.inputs[row.key] for row in program.launch]
    memory = np.zeros(launch.memory.size + _SLACK, np.uint32)
    memory[:-_SLACK] = launch.memory
    return MachineState(context, constants, memory)
