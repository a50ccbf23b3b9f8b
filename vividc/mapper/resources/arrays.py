"""Flat arrays, the form in which compiled functions read graphs and fabrics."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

Ints: TypeAlias = NDArray[np.int64]
Floats: TypeAlias = NDArray[np.float64]
Bytes: TypeAlias = NDArray[np.uint8]
Ints2: TypeAlias = Annotated[Ints, 2]
Ints3: TypeAlias = Annotated[Ints, 3]
Floats2: TypeAlias = Annotated[Floats, 2]
Floats3: TypeAlias = Annotated[Floats, 3]
Bytes2: TypeAlias = Annotated[Bytes, 2]
"""Of so many dimensions, for the compiler; others have one."""


@dataclass(frozen=True, slots=True)
class Rows:
    """A list of int64 for each of n things: row i is items[begin[i] : begin[i + 1]]."""

    begin: Ints
    items: Ints

    @staticmethod
    def of(rows: Iterable[Iterable[int]]) -> Rows:
        """Pack rows of numbers."""
        packed = [list(row) for row in rows]
        begin = np.zeros(len(packed) + 1, dtype=np.int64)
        begin[1:] = np.cumsum([len(row) for row in packed])
        return Rows(begin, np.array([i for row in packed for i in row], dtype=np.int64))

    def __getitem__(self, row: int) -> list[int]:
        """One row."""
        return [int(i) for i in self.items[self.begin[row] : self.begin[row + 1]]]


def ints(values: Iterable[int]) -> Ints:
    """An int64 array."""
    return np.fromiter(values, dtype=np.int64)
