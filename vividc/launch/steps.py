"""The steps of a launch graph: what an accelerator can be told to do."""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vividc.program import WORD_BYTES, Program

Array = NDArray[np.generic]
Moving = Literal["move in", "gather", "move out", "scatter"]
Kind = Literal[Moving, "configure", "run"]


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Contiguous runs of bytes in DRAM, one after the other, of array number `buffer`.

    `spans`: int64 [n, 2], from which byte of the array each runs, and how many bytes.
    """

    buffer: int
    spans: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Listed:
    """Indices that a run leaves in the scratchpad of its tile: the word at byte `address` says how
    many follow it, of which a gather or scatter takes the first `most`.
    """

    address: int
    most: int

    @property
    def extent(self) -> tuple[int, int]:
        """First byte and end of the longest list and its length."""
        return self.address, self.address + WORD_BYTES * (1 + self.most)


@dataclass(frozen=True, slots=True, eq=False)
class Transfer:
    """Moves bytes of DRAM to or from one place in the scratchpads, where they lie one after the
    other.

    Attributes
    ----------
    tiles
        Where it goes; several tiles get the same words at the same time. What leaves comes from
        one.
    address
        First byte in the scratchpad.
    index_pieces
        Where the indices of a gather or scatter lie: they are read first, and go no further than
        the engine.
    listed
        Where they lie if that is in the scratchpad.
    count_at
        First byte of a word of the scratchpad that says how many rows of the array a move out
        moves; without it all move.
    view
        The array whose elements move, as the caller gave it (by indices: its chosen rows).
    after
        Steps that must be done before.
    pitch
        Bytes from a word to the next in the scratchpad.
    """

    kind: Moving
    tiles: tuple[int, ...]
    address: int
    pieces: Pieces
    view: Array
    index_pieces: Pieces | None = None
    indices: Array | None = None
    after: tuple[int, ...] = ()
    pitch: int = WORD_BYTES
    listed: Listed | None = None
    count_at: int | None = None

    @property
    def to_dram(self) -> bool:
        """Whether it goes from a scratchpad to DRAM."""
        return self.kind in ("move out", "scatter")

    @property
    def told_at(self) -> tuple[int, int] | None:
        """First byte and end, at most, of what the engine reads in the tile's scratchpad to know
        what to move.
        """
        if self.count_at is not None:
            return self.count_at, self.count_at + WORD_BYTES
        return None if self.listed is None else self.listed.extent

    @property
    def size(self) -> int:
        """Bytes that go to or from each scratchpad, at most."""
        if self.listed is not None:
            return self.listed.most * self.view[:1].nbytes
        if self.indices is not None:
            return len(self.indices) * self.view[:1].nbytes
        return self.view.nbytes

    def places(self, size: int) -> slice:
        """Where `size` bytes lie: of the scratchpad's bytes if they lie together, else of its
        words.
        """
        if self.pitch == WORD_BYTES:
            return slice(self.address, self.address + size)
        first, step = self.address // WORD_BYTES, self.pitch // WORD_BYTES
        return slice(first, first + size // WORD_BYTES * step, step)

    def extent(self, size: int) -> tuple[int, int]:
        """First byte and end of all that lies between the first and the last of `size` bytes."""
        if self.pitch == WORD_BYTES or not size:
            return self.address, self.address + size
        return self.address, self.address + (size // WORD_BYTES - 1) * self.pitch + WORD_BYTES


@dataclass(frozen=True, slots=True, eq=False)
class Configure:
    """Streams a program into the configuration memories of tiles.

    `programs`: that of each tile in `tiles`, mirrored as the tile is.
    """

    tiles: tuple[int, ...]
    programs: tuple[Program, ...]
    after: tuple[int, ...] = ()

    @property
    def entries(self) -> int:
        """What is written: an entry for each PE and context, and each word of a constant table."""
        contexts = sum(len(p.fabric.pes) * len(p.words) for p in self.programs)
        return contexts + sum(len(loc.contents or ()) for p in self.programs for loc in p.locals)


@dataclass(frozen=True, slots=True, eq=False)
class Execute:
    """Runs the program that a tile holds.

    Attributes
    ----------
    program
        Mirrored as the tile is.
    compiled
        What it is an image of: it gives the same memory in the same cycles.
    inputs
        Word of each launch key.
    extents
        First byte and end of each array in the scratchpad.
    stores
        First byte and end of what the run may write of each array it writes.
    configured_by
        The `Configure` that brought the program.
    """

    tile: int
    program: Program
    compiled: Program
    inputs: ReadOnly[str, int]
    extents: ReadOnly[str, tuple[int, int]]
    stores: ReadOnly[str, tuple[int, int]]
    configured_by: int
    after: tuple[int, ...] = ()

    @property
    def launch_words(self) -> int:
        """Constant-store entries that the tile controller writes before the first cycle."""
        return int(self.program.images_set.sum()) + len(self.program.launch)


Step = Transfer | Configure | Execute


def tiles_of(step: Step) -> tuple[int, ...]:
    """The tiles that a step touches."""
    return (step.tile,) if isinstance(step, Execute) else step.tiles


def kind_of(step: Step) -> Kind:
    """What a step does, in words."""
    if isinstance(step, Transfer):
        return step.kind
    return "configure" if isinstance(step, Configure) else "run"
