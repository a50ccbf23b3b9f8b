"""Lists of lists as two arrays, the form that compiled functions read."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray

Ints: TypeAlias = NDArray[np.int64]
Ints2: TypeAlias = Annotated[Ints, 2]
"""Of two dimensions, for the compiler of inner loops."""


def flat(lists: Sequence[Sequence[int]]) -> tuple[Ints, Ints]:
    """Return where each list's items begin, and behind the last [n + 1], and the items."""
    begin = np.zeros(len(lists) + 1, dtype=np.int64)
    np.cumsum([len(items) for items in lists], out=begin[1:])
    return begin, np.fromiter(chain.from_iterable(lists), dtype=np.int64, count=begin[-1])
