"""Finds unordered uses of the same bytes in flat arrays; compiled."""

from __future__ import annotations

from typing import Final

import numpy as np

from vividc.host.machine_code import Compiler
from vividc.launch.flat import Ints, Ints2

compiled: Final = Compiler()
PLACE, START, END, STEP, WRITES = range(5)
"""Columns of a list of uses: a memory; first byte and end; the step; whether it writes."""

_BITS = 64
_NONE = -1


def first_race(uses: Ints, wait_begin: Ints, wait_items: Ints) -> tuple[int, int, int] | None:
    """Return two steps, the earlier first, that use the same bytes of a memory, at least one of
    them writing, where the later does not wait for the earlier even indirectly; and the memory.
    None: there is no such pair.

    Parameters
    ----------
    uses
        [n, 5], see the columns.
    wait_begin, wait_items
        Step s waits for `wait_items[wait_begin[s]:wait_begin[s + 1]]`, which are before it.
    """
    writes = np.unique(uses[uses[:, WRITES] > 0, PLACE])
    uses = uses[np.isin(uses[:, PLACE], writes)]
    uses = uses[np.lexsort((uses[:, STEP], uses[:, START], uses[:, PLACE]))]
    steps = len(wait_begin) - 1
    rows = np.zeros(steps + 1, dtype=np.int64)
    np.cumsum(np.arange(steps) // _BITS + 1, out=rows[1:])
    reach = np.zeros(rows[-1], dtype=np.int64)
    _reach(reach, rows, wait_begin, wait_items)
    race = np.full(3, _NONE, dtype=np.int64)
    _sweep(uses, reach, rows, np.empty(len(uses), dtype=np.int64), race)
    early, late, place = race.tolist()
    return None if early == _NONE else (early, late, place)


@compiled
def _reach(reach: Ints, rows: Ints, wait_begin: Ints, wait_items: Ints) -> None:
    """For each step the steps before it that it waits for, as bits; its row has no more words than
    it needs.
    """
    for step in range(len(wait_begin) - 1):
        row = rows[step]
        for place in range(wait_begin[step], wait_begin[step + 1]):
            before = wait_items[place]
            for word in range(rows[before + 1] - rows[before]):
                reach[row + word] |= reach[rows[before] + word]
            reach[row + before // _BITS] |= 1 << before % _BITS


@compiled
def _sweep(uses: Ints2, reach: Ints, rows: Ints, open_: Ints, race: Ints) -> None:
    """Go through the uses, which are in order of place, start and step, and keep those that have
    not ended in `open_`.
    """
    count = 0
    for number in range(len(uses)):
        kept = 0
        for place in range(count):
            other = open_[place]
            if uses[other, PLACE] == uses[number, PLACE] and uses[other, END] > uses[number, START]:
                open_[kept] = other
                kept += 1
        for place in range(kept):
            other = open_[place]
            one, two = uses[other, STEP], uses[number, STEP]
            early, late = min(one, two), max(one, two)
            is_race = uses[other, WRITES] + uses[number, WRITES] > 0 and early != late
            if is_race and not _follows(reach, rows, early, late):
                race[0], race[1], race[2] = early, late, uses[number, PLACE]
                return
        open_[kept] = number
        count = kept + 1


@compiled
def _follows(reach: Ints, rows: Ints, early: int, late: int) -> bool:
    bit = 1 << early % _BITS
    return bool(reach[rows[late] + early // _BITS] & bit)
