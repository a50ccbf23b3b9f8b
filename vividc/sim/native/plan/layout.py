"""The context: what native code and its caller share, an array of 64-bit words.

The scratchpad and the constant stores are arrays of their own. Registers, links and results exist
only inside the code of a region, or in the context's last words while a loop is suspended.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from vividc.program import Program
from vividc.program.dataflow import Constant
from vividc.program.reloads import reloads_of

BITS: Final = 64
MEMORY_SLACK_BYTES: Final = 8
"""Bytes behind the scratchpad that take what does not happen."""


class Place(IntEnum):
    """Fixed words of the context."""

    NEXT = 0  # region to run next, -1: the program has ended
    CYCLE = 1
    ENTRIES = 2  # regions run
    ENTRY_STOP = 3  # return before this many regions are exceeded
    CYCLE_LIMIT = 4
    BUDGET = 5  # return soon after this cycle
    TRIP = 6
    SWITCH_CYCLES = 7
    RESUME = 8  # 1: inside a loop, which was suspended
    NOW = 9  # cycle of the suspension
    TABLES = 10  # address of the words of all tables
    OVERLAP = 11  # cycles of region NEXT in which the one before it was still under way
    RELOAD_CYCLES = 12  # those of SWITCH_CYCLES in which contexts were brought


class Status(IntEnum):
    """Why native code returned."""

    DONE = 0  # the program ended
    SUSPENDED = 1  # the budget is used up
    STOPPED = 2  # at ENTRY_STOP
    LIMIT = 3  # at CYCLE_LIMIT, in region NEXT
    IRREGULAR = 4  # region NEXT is for the reference engine; nothing of it was done
    FAULT = 5  # something in region NEXT broke a rule; the state is no longer good


class Sum(IntEnum):
    """Sums over the runs of one region; its classes of counts follow."""

    ENTRIES = 0
    NONEMPTY = 1  # runs with an iteration
    ITERATIONS = 2
    CYCLES = 3
    STALLS = 4
    CONSTANT_WRITES = 5
    CAPTURE_READS = 6  # register reads by live-outs
    READS = 7
    WRITES = 8


@dataclass(frozen=True)
class Layout:
    """Places of what depends on the program.

    Attributes
    ----------
    bits
        Number of each constant-store entry that no launch sets: its bit among the valid ones.
    arrays
        Number of each array that memory operations name.
    held
        Words with a bit for each region whose contexts are held, of a long program.
    sums
        First word of each region's sums.
    spill
        First word for a suspended loop.
    """

    entries: int
    bits: Mapping[Constant, int]
    arrays: Mapping[str, int]
    valid: int
    held: range
    extents: int
    sums: Sequence[int]
    spill: int

    def cell(self, constant: Constant) -> int:
        """Index of a constant-store entry."""
        return constant.pe * self.entries + constant.entry

    def valid_word(self, bit: int) -> int:
        """Word of the context that holds a valid bit."""
        return self.valid + bit // BITS


def layout(program: Program, classes: Sequence[int]) -> Layout:
    """Places for a program whose regions have so many classes of counts."""
    pes, entries = program.images_set.shape
    launched = {(row.pe, row.entry) for row in program.launch}
    unset = [
        Constant(pe, entry)
        for pe in range(pes)
        for entry in range(entries)
        if not program.images_set[pe, entry] and (pe, entry) not in launched
    ]
    arrays = {name: k for k, name in enumerate(dict.fromkeys(_array_names(program)))}
    valid = len(Place)
    first = valid + -(-len(unset) // BITS)
    is_long = reloads_of(program) is not None
    extents = first + (-(-len(program.table) // BITS) if is_long else 0)
    held = range(first, extents)
    starts = extents + EXTENT_WORDS * len(arrays)
    sizes = [len(Sum) + count for count in classes]
    sums = [starts + sum(sizes[:k]) for k in range(len(sizes))]
    bits = {cell: k for k, cell in enumerate(unset)}
    return Layout(entries, bits, arrays, valid, held, extents, sums, starts + sum(sizes))


EXTENT_WORDS: Final = 4
"""Of an array: its first byte, and the offsets below which 1, 2 and 4 bytes lie inside."""
BOUND_OF_WIDTH: Final = {1: 1, 2: 2, 4: 3}


def _array_names(program: Program) -> list[str]:
    return ["", *(row.name for row in program.debug if row.op in ("load", "store"))]
