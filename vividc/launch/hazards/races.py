"""Finds unordered uses of the same bytes in flat arrays; compiled."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from vividc.host.machine_code import Compiler
from vividc.launch.flat import Ints, Ints2

compiled: Final = Compiler()
PLACE, START, END, STEP, WRITES = range(5)
"""Columns of a list of uses: a memory; first byte and end; the step; whether it writes."""

_STEP, _NEXT = range(2)
"""Columns of `Parts.readers`."""
_NONE: Final = -1
_CHAINS: Final = 64
"""That are tried first, and then twice as many."""


class Order(NamedTuple):
    """Which steps wait for which, also indirectly, by chains of steps each of which follows the
    one before (Jagadish, ACM TODS 15, 1990): a step follows the first few of each chain.

    Attributes
    ----------
    chain, number
        [n] of each step, and which of its chain it is, from 1 on.
    followed
        [n, chains]: how many of each chain a step follows; of its own, with itself.
    """

    chain: Ints
    number: Ints
    followed: Ints2


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
    if not len(uses):
        return None
    uses = uses[np.lexsort((uses[:, WRITES], uses[:, STEP]))]  # a step reads, and then writes
    first, last = _parts(uses)
    order = order_of(wait_begin, wait_items)
    race = np.full(2, _NONE, dtype=np.int64)
    writer, reader = np.full((2, int(last.max())), _NONE, dtype=np.int64)
    room = len(reader) + len(uses)
    while True:
        readers = np.zeros((room, 2), dtype=np.int64)
        readers[:, _NEXT] = np.arange(1, room + 1)
        writer[:] = reader[:] = _NONE
        if _follow(uses, first, last, order, Parts(writer, reader, readers), race):
            break
        room *= 2
    early, number = race.tolist()
    if early == _NONE:
        return None
    return early, int(uses[number, STEP]), int(uses[number, PLACE])


def _parts(uses: Ints) -> tuple[Ints, Ints]:
    """Return the first part of all memories that each use covers, and the one behind its last: they
    are cut wherever a use begins or ends.
    """
    _, places = np.unique(uses[:, PLACE], return_inverse=True)
    offset = places * (uses[:, END].max() + 1)
    starts, ends = offset + uses[:, START], offset + uses[:, END]
    cuts = np.unique(np.concatenate((starts, ends)))
    return np.searchsorted(cuts, starts), np.searchsorted(cuts, ends)


class Parts(NamedTuple):
    """Who has used each part of the memories so far.

    Attributes
    ----------
    writer
        The last step that wrote it; none.
    reader
        The place in `readers` of one that has read it since; none.
    readers
        [n, 2] steps, and the place of the next one that has read the same part; free ones follow
        each other.
    """

    writer: Ints
    reader: Ints
    readers: Ints2


def order_of(wait_begin: Ints, wait_items: Ints) -> Order:
    """Return the order of steps, of which each waits for some before it, as of `first_race`."""
    steps, chains = len(wait_begin) - 1, _CHAINS
    while True:
        chain, number = np.zeros((2, steps), dtype=np.int64)
        followed = np.zeros((steps, min(chains, steps)), dtype=np.int64)
        lengths = np.zeros(followed.shape[1], dtype=np.int64)
        if _chain(Order(chain, number, followed), lengths, wait_begin, wait_items):
            return Order(chain, number, followed)
        chains *= 2


@compiled
def _chain(order: Order, lengths: Ints, wait_begin: Ints, wait_items: Ints) -> bool:
    """Append each step to the first chain whose last one it follows, or else begin one; False:
    there is no room for that.
    """
    followed, used = order.followed, 0
    for step in range(len(order.chain)):
        for place in range(wait_begin[step], wait_begin[step + 1]):
            before = wait_items[place]
            for chain in range(used):
                followed[step, chain] = max(followed[step, chain], followed[before, chain])
        own = 0
        while own < used and followed[step, own] < lengths[own]:
            own += 1
        if own == used:
            if used == len(lengths):
                return False
            used += 1
        lengths[own] += 1
        order.chain[step] = own
        order.number[step] = lengths[own]
        followed[step, own] = lengths[own]
    return True


@compiled
def _follow(uses: Ints2, first: Ints, last: Ints, order: Order, parts: Parts, race: Ints) -> bool:
    """Go through the uses, which are in the order of steps, up to one that does not follow the last
    that wrote a part of it, or, if it writes, those that have read it since; `race` gets that step
    and the number of the use. What is before these is before the use if they are. False: there is
    no room for all that have read.
    """
    free, readers = 0, parts.readers
    for number in range(len(uses)):
        step, writes = uses[number, STEP], uses[number, WRITES] > 0
        for part in range(first[number], last[number]):
            if not _follows(order, parts.writer[part], step):
                race[0], race[1] = parts.writer[part], number
                return True
            # Of those that have read it, only the ones that this step does not follow stay.
            place, kept = parts.reader[part], _NONE
            while place != _NONE:
                behind = readers[place, _NEXT]
                if _follows(order, readers[place, _STEP], step):
                    readers[place, _NEXT] = free
                    free = place
                elif writes:
                    race[0], race[1] = readers[place, _STEP], number
                    return True
                else:
                    readers[place, _NEXT] = kept
                    kept = place
                place = behind
            if writes:
                parts.writer[part] = step
            else:
                if free == len(readers):
                    return False
                place, free = free, readers[free, _NEXT]
                readers[place, _STEP], readers[place, _NEXT] = step, kept
                kept = place
            parts.reader[part] = kept
    return True


@compiled
def _follows(order: Order, early: int, late: int) -> bool:
    """Whether a step is another, or waits for it, or that is none."""
    if early == _NONE:
        return True
    return early == late or bool(order.followed[late, order.chain[early]] >= order.number[early])
