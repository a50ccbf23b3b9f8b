"""DRAM as the host's numpy arrays: where the bytes of a view lie, and working copies of what is
written.
"""

from __future__ import annotations

from bisect import bisect

import numpy as np
from numpy.lib.array_utils import byte_bounds
from numpy.typing import NDArray

from vividc.errors import ArgumentError
from vividc.launch.steps import Array, Pieces


class Buffers:
    """The arrays that views are of, numbered in the order in which they are first seen. Each starts
    at a burst boundary of DRAM.
    """

    def __init__(self) -> None:
        self._roots: list[Array] = []
        self._lows: list[int] = []
        self._numbers: dict[int, int] = {}
        self._kept: list[Array] = []
        self._bounds: list[tuple[int, int, int]] = []  # first byte, end, number; in order

    def number(self, view: Array) -> int:
        """Number of the array that `view` is of.

        Raises
        ------
        ArgumentError
            It shares memory with an array of the job, and is neither a view of it nor inside it.
        """
        root = _root(view)
        if id(root) not in self._numbers:
            self._numbers[id(root)] = self._number_of(root)
            self._kept.append(root)  # keeps the id from being used again
        return self._numbers[id(root)]

    def _number_of(self, root: Array) -> int:
        """Arrays over one buffer of another kind (`np.frombuffer`) have no array in common, and
        are one memory all the same.
        """
        low, high = byte_bounds(root)
        at = bisect(self._bounds, (low, high))
        for start, end, number in self._bounds[max(at - 1, 0) : at + 1]:
            if root.size and start <= low and high <= end:
                return number
            if root.size and start < high and low < end:
                raise ArgumentError(
                    "two arrays of a job share memory, and neither is a view of the other",
                    hint="make both views of one numpy array, or pass a copy",
                )
        number = len(self._roots)
        self._roots.append(root)
        self._lows.append(low)
        if root.size:
            self._bounds.insert(at, (low, high, number))
        return number

    def root(self, number: int) -> Array:
        """The array of a number."""
        return self._roots[number]

    def pieces(self, view: Array) -> Pieces:
        """The contiguous runs of bytes of `view` in DRAM, in C order of its elements."""
        number = self.number(view)
        if view.size == 0:
            return Pieces(number, np.empty((0, 2), dtype=np.int64))
        axes = list(zip(view.shape, view.strides, strict=True))
        run = view.itemsize
        while axes and (axes[-1][1] == run or axes[-1][0] == 1):
            run *= axes.pop()[0]
        starts = np.array([self.start(view, number)], dtype=np.int64)
        for count, stride in axes:
            starts = (starts[:, None] + np.arange(count) * stride).reshape(-1)
        return Pieces(number, _spans(starts, run))

    def rows(self, view: Array, indices: NDArray[np.int64], granule: int) -> Pieces:
        """The places of `view[indices]`; rows that follow each other in the array are one, and so
        are all in a row that lie in one granule of DRAM, of so many bytes, if they are together no
        longer than it. With granules of one byte a place has the bytes of its rows, and no others.
        """
        number, row = self.number(view), view[:1].nbytes
        firsts = _changes(indices - np.arange(len(indices))).nonzero()[0]
        counts = _lengths(firsts, len(indices))
        starts = self.start(view, number) + row * indices[firsts]
        return Pieces(number, _in_granules(starts, row * counts, granule))

    def start(self, view: Array, number: int) -> int:
        """The byte of its array, which has this number, at which a view starts."""
        return int(view.__array_interface__["data"][0]) - self._lows[number]


class Working:
    """DRAM during a simulation: arrays that are written are copies until `commit`."""

    def __init__(self, buffers: Buffers, written: set[int]) -> None:
        self._buffers = buffers
        self._copies = {number: _flat(buffers.root(number)).copy() for number in written}

    def read(self, view: Array) -> Array:
        """`view` as it is in DRAM now."""
        number = self._buffers.number(view)
        if number not in self._copies:
            return view
        return self._on_copy(view, number)

    def write(self, view: Array, raw: NDArray[np.uint8]) -> None:
        """Give `view` in DRAM the elements whose bytes are `raw`, in C order."""
        copy = self._on_copy(view, self._buffers.number(view))
        copy[...] = raw.view(view.dtype).reshape(view.shape)

    def write_rows(self, view: Array, rows: NDArray[np.int64], raw: NDArray[np.uint8]) -> None:
        """Give these rows of `view` in DRAM the elements whose bytes are `raw`, one row after the
        other: of a row that is there twice the last counts.
        """
        copy = self._on_copy(view, self._buffers.number(view))
        elements = raw.view(view.dtype).reshape(len(rows), *view.shape[1:])
        once, from_behind = np.unique(rows[::-1], return_index=True)
        copy[once] = elements[len(rows) - 1 - from_behind]

    def commit(self, views: list[Array]) -> None:
        """Write the views, as they are in DRAM, into the caller's arrays."""
        for view in views:
            view[...] = self._on_copy(view, self._buffers.number(view))

    def _on_copy(self, view: Array, number: int) -> Array:
        offset = self._buffers.start(view, number)
        return np.ndarray(view.shape, view.dtype, self._copies[number].data, offset, view.strides)


def _root(view: Array) -> Array:
    while isinstance(view.base, np.ndarray):
        view = view.base
    return view


def _flat(root: Array) -> NDArray[np.uint8]:
    """All bytes of an array, whatever its strides."""
    low, high = byte_bounds(root)
    if root.flags.c_contiguous:
        return root.reshape(-1).view(np.uint8)
    first = root.__array_interface__["data"][0] - low
    whole = np.zeros(high - low, np.uint8)
    copy = np.ndarray(root.shape, root.dtype, whole.data, first, root.strides)
    copy[...] = root
    return whole


def _in_granules(
    starts: NDArray[np.int64], sizes: NDArray[np.int64], granule: int
) -> NDArray[np.int64]:
    """All pieces in a row that lie in one granule, if they are together no longer than it, as one
    of so many bytes, whose start only says which granule.
    """
    inside = starts // granule
    alone = inside != (starts + sizes - 1) // granule
    # Each that reaches into another granule is told from all others.
    inside[alone] = -1 - np.flatnonzero(alone)
    changes = _changes(inside)
    firsts = changes.nonzero()[0]
    together = np.add.reduceat(sizes, firsts) if len(firsts) else sizes
    joined = np.repeat(together <= granule, _lengths(firsts, len(sizes)))
    firsts = (changes | ~joined).nonzero()[0]
    sums = np.add.reduceat(sizes, firsts) if len(firsts) else sizes
    begins = starts[firsts]
    ends = (begins // granule + 1) * granule
    return _spans(np.where(sums > sizes[firsts], np.minimum(begins, ends - sums), begins), sums)


def _changes(values: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Where each of equal values in a row begin."""
    changes = np.ones(len(values), dtype=np.bool_)
    np.not_equal(values[1:], values[:-1], out=changes[1:])
    return changes


def _lengths(firsts: NDArray[np.int64], end: int) -> NDArray[np.int64]:
    """How many there are from each of these to the next, or to the end."""
    lengths = np.empty(len(firsts), dtype=np.int64)
    np.subtract(firsts[1:], firsts[:-1], out=lengths[:-1])
    lengths[-1:] = end - firsts[-1:]
    return lengths


def _spans(starts: NDArray[np.int64], sizes: NDArray[np.int64] | int) -> NDArray[np.int64]:
    spans = np.empty((len(starts), 2), dtype=np.int64)
    spans[:, 0], spans[:, 1] = starts, sizes
    return spans
