"""The mutable state of a native run, in arrays that the machine code works on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.machine.words import WORD_MASK
from vividc.program import Home, Program
from vividc.program.dataflow import Constant
from vividc.program.reloads import reloads_of
from vividc.sim.engine import Launch
from vividc.sim.native.plan.layout import BITS, MEMORY_SLACK_BYTES, Layout, Place

_SLACK = MEMORY_SLACK_BYTES // 4
NEVER: Final = (1 << 62) - 1
"""A cycle that no run reaches."""


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

    def held(self, layout: Layout) -> int:
        """Regions of a long program whose contexts are held: a bit each."""
        words = self.context[layout.held.start : layout.held.stop]
        return int.from_bytes(words.astype("<i8").tobytes(), "little")

    def hold(self, layout: Layout, held: int) -> None:
        """Set them."""
        words = held.to_bytes(8 * len(layout.held), "little")
        self.context[layout.held.start : layout.held.stop] = np.frombuffer(words, "<i8")

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


class Blank:
    """What is the same in all launches of a program.

    Parameters
    ----------
    words
        Of the context (see `layout`).
    """

    def __init__(self, program: Program, layout: Layout, words: int) -> None:
        self._layout, self._words = layout, words
        self._everywhere = (0, program.fabric.scratchpad.size_bytes)
        self._image = np.where(program.images_set, program.images, 0).astype(np.uint32).reshape(-1)
        self._keys = [row.key for row in program.launch]
        self._reloads = reloads_of(program)
        places = [row.pe * layout.entries + row.entry for row in program.launch]
        self._places = np.array(places, dtype=np.int64)

    def takes(self, launch: Launch) -> bool:
        """Whether native code can take a launch: `simulate` makes no others."""
        size = self._everywhere[1]
        words = [0, *map(launch.inputs.__getitem__, self._keys)]
        inside = all([0 <= first <= end <= size for first, end in launch.extents.values()])
        fits = launch.memory.nbytes == size and 0 <= launch.cycle_limit < NEVER
        return inside and min(words) >= 0 and max(words) <= WORD_MASK and fits

    def state(self, launch: Launch) -> MachineState:
        """The tile as the host leaves it at a launch."""
        context = np.zeros(self._words, np.int64)
        context[Place.CYCLE_LIMIT] = launch.cycle_limit
        words: list[int] = []
        for name in self._layout.arrays:
            first, end = launch.extents.get(name, self._everywhere)
            size = end - first
            words += (first, size, max(0, size - 1), max(0, size - 3))
        start = self._layout.extents
        context[start : start + len(words)] = words
        constants = self._image.copy()
        constants[self._places] = [*map(launch.inputs.__getitem__, self._keys)]
        memory = np.empty(launch.memory.size + _SLACK, np.uint32)
        memory[:-_SLACK], memory[-_SLACK:] = launch.memory, 0
        state = MachineState(context, constants, memory)
        if self._reloads is not None:
            state.hold(self._layout, self._reloads.held)
        return state
