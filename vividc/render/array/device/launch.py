"""What one run of a kernel takes and leaves: a launch."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from vividc.machine.words import WORD_BYTES

Words = npt.NDArray[np.generic]
Sizes: TypeAlias = dict[str, int]
"""Bytes of arrays by name."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """Rows of a table, by indices [n] int32 or uint32 that DRAM holds when the job runs."""

    table: Words
    indices: Words

    @property
    def nbytes(self) -> int:
        """Of the chosen rows."""
        return len(self.indices) * int(self.table[:1].nbytes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the chosen rows, one below the other."""
        return (len(self.indices), *self.table.shape[1:])


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Elements of a kernel's array, from `first` on, that are copied from or to an array, or are
    rows of one.
    """

    array: Words | Gathered
    first: int = 0

    @property
    def first_byte(self) -> int:
        """Of the kernel's array."""
        return WORD_BYTES * self.first


@dataclass(frozen=True, slots=True, eq=False)
class Fetched:
    """Rows of a table that the kernel itself asks for, in an array of words.

    A launch runs twice. With the scalar `phase` 0 the kernel writes there how many rows it wants,
    and behind that word their numbers. They come to the same place, from word `first` on, and the
    kernel runs with `phase` 1. Of more than `most` rows none is to be asked for.
    """

    table: Words
    most: int
    first: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Words of the array."""
        row = self.table[:1].nbytes // WORD_BYTES
        return (max(1 + self.most, self.first + row * self.most),)


Moved: TypeAlias = Words | Gathered | Sequence[Move]
"""A whole array, contiguous or strided, rows of one, or pieces."""


@dataclass(frozen=True, slots=True, eq=False)
class Launch:
    """One run of a kernel; arrays have elements of four bytes.

    Attributes
    ----------
    shapes
        Of array parameters that are moved in pieces, or are larger than what is moved, and of those
        that the kernel works in.
    inputs
        What is moved in before, by parameter.
    outputs
        What is moved out after it: arrays or pieces, not rows.
    shared
        What stays in the scratchpad while the next launches of the tile name the same object.
    fetched
        Rows that the kernel asks for, by parameter.
    carried
        Arrays that launches in a row, which name the same ones, hand on to each other. They stay in
        a scratchpad, and leave after the last of these launches.
    starts
        What carried arrays hold before the first of these launches; of the others nothing.
    work
        Arrays that hold nothing when the kernel starts or ends, by parameter.
    scalars
        The other arguments.
    counted
        Whole outputs of which only the first rows leave, and the parameter whose first word says
        how many when the kernel is done.
    cost
        How long it takes, in any unit: `Device.run` deals out by it.
    """

    shapes: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    inputs: Mapping[str, Moved] = field(default_factory=dict)
    outputs: Mapping[str, Words | Sequence[Move]] = field(default_factory=dict)
    shared: Mapping[str, Moved] = field(default_factory=dict)
    fetched: Mapping[str, Fetched] = field(default_factory=dict)
    carried: Mapping[str, Words] = field(default_factory=dict)
    starts: Mapping[str, Words] = field(default_factory=dict)
    work: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    scalars: Mapping[str, object] = field(default_factory=dict)
    counted: Mapping[str, str] = field(default_factory=dict)
    cost: float = 1.0

    @property
    def sizes(self) -> Sizes:
        """Bytes of each array that is neither held nor work."""
        rows = {name: some.shape for name, some in self.fetched.items()}
        own = bytes_of({**rows, **self.shapes})
        own |= {name: array.nbytes for name, array in self._whole(self.inputs, self.outputs)}
        return {name: size for name, size in own.items() if name not in self.held}

    @property
    def held_sizes(self) -> Sizes:
        """Bytes of each array that stays."""
        whole = {name: array.nbytes for name, array in self._whole(self.held)}
        known = {**whole, **bytes_of(self.shapes)}
        return {name: known[name] for name in self.held}

    @property
    def all_shapes(self) -> dict[str, tuple[int, ...]]:
        """Of each array."""
        whole = self._whole(self.inputs, self.outputs, self.held)
        shapes = {name: array.shape for name, array in (*whole, *self.fetched.items())}
        return {**shapes, **self.shapes, **self.work}

    @property
    def group(self) -> tuple[int, ...]:
        """A key that is equal for launches with the same held arrays."""
        return tuple(map(id, self.held.values()))

    @property
    def held(self) -> dict[str, Moved]:
        """Arrays that stay in a scratchpad from launch to launch."""
        return {**self.shared, **self.carried}

    def _whole(self, *arrays: Mapping[str, Moved]) -> Iterator[tuple[str, Words | Gathered]]:
        for some in arrays:
            for name, array in some.items():
                if isinstance(array, np.ndarray | Gathered) and name not in self.shapes:
                    yield name, array


def pieces(moved: Moved) -> Sequence[Move]:
    """Return what is moved, piece by piece."""
    return (Move(moved),) if isinstance(moved, np.ndarray | Gathered) else moved


def bytes_of(shapes: Mapping[str, tuple[int, ...]]) -> Sizes:
    """Return the bytes of arrays of words."""
    return {name: WORD_BYTES * math.prod(shape) for name, shape in shapes.items()}
