"""What words take where an output register is their only way out of a PE: compiled functions.

Every cycle in which another PE reads a word takes the output register of the PE that shows it, and
the FU that fills it: the result's own, or a move's. The annealer claims those moves while it places
nodes, each by the cheapest of a few ways, so that what it calls free of crowding has routes. Words
that wait stay in registers, which are taken for sufficient: those are the router's part.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vividc.mapper.engines.negotiate.arrays import Array, Edges, Task
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.engines.negotiate.places import Places, count
from vividc.mapper.resources.arrays import Ints, Ints2, Ints3

_MOST_CELLS = 96
MOST_HOPS = 24
"""Links of the longest way for which moves are claimed: most longer ones are passing proposals."""
_CELL, _TAKEN = 1.0, 15.0
"""What a move costs, and each of its two claims that meets another."""
_MANY_CELLS = 16
"""Cells from which on the nearest is looked for first: with its price most others are passed by."""
_MOST_READS = 64
"""Reads of a word for which moves are claimed: the time of a claim grows with their square."""


class Words(NamedTuple):
    """Where words are shown: by producer `size` cells, each a `pe` and a `cycle` from the result's
    cycle on, the result itself first. Work space: `path` for two ways, `reads` for the reads of one
    word in order of time, as (cycles from the result, PE).
    """

    size: Ints
    pe: Ints2
    cycle: Ints2
    path: Ints3
    reads: Ints2


class Read(NamedTuple):
    """A read of `word`, which is `ready` in that cycle, on PE `target` `gap` cycles later."""

    word: int
    ready: int
    target: int
    gap: int


def new_words(task: Task) -> Words:
    """No word is shown anywhere."""
    producers = len(task.nodes.latency)
    most = _MOST_CELLS if task.array.moves else 1
    reads = int(np.diff(task.edges.sink_begin).max(initial=0))
    shape = (producers, most)
    return Words(
        np.zeros(producers, dtype=np.int64),
        np.zeros(shape, dtype=np.int64),
        np.zeros(shape, dtype=np.int64),
        np.zeros((2, 2 * task.array.pes + 2, 2), dtype=np.int64),
        np.zeros((reads, 2), dtype=np.int64),
    )


@compiled
def withdraw(task: Task, places: Places, words: Words, word: int) -> None:
    """Take back what is claimed for a word."""
    _claim_all(task, places, words, word, -1)
    words.size[word] = 0


@compiled
def show_all(task: Task, places: Places, words: Words) -> None:
    """Claim for all words, of which none is shown, where FUs move them."""
    if task.array.moves:
        for word in range(len(words.size)):
            show(task, places, words, word)


@compiled
def hide_all(task: Task, places: Places, words: Words) -> None:
    """Take back all claims; the records stay."""
    for word in range(len(words.size)):
        _claim_all(task, places, words, word, -1)


@inlined
def _claim_all(task: Task, places: Places, words: Words, word: int, by: int) -> None:
    ready = places.time[word] + task.nodes.latency[word]
    for at in range(1, words.size[word]):
        _claim(task.array, places, words.pe[word, at], ready + words.cycle[word, at], by)


@compiled
def claim_again(task: Task, places: Places, words: Words, word: int) -> None:
    """Claim what the records of a word say."""
    _claim_all(task, places, words, word, 1)


@compiled
def clashes_of(task: Task, places: Places, words: Words, word: int) -> int:
    """Claims for a word that meet others."""
    ii, grid = task.array.ii, task.array.pes * task.array.ii
    ready = places.time[word] + task.nodes.latency[word]
    met = 0
    for at in range(1, words.size[word]):
        cell = words.pe[word, at] * ii + (ready + words.cycle[word, at] - 1) % ii
        met += (places.counts[cell] > 1) + (places.counts[grid + cell] > 1)
    return met


@inlined
def _claim(array: Array, places: Places, pe: int, shown: int, by: int) -> None:
    """A move on `pe` whose word is shown from cycle `shown` on."""
    at = pe * array.ii + (shown - 1) % array.ii
    count(places, at, by, 1)
    count(places, array.pes * array.ii + at, by, 1)


@inlined
def _price(array: Array, places: Places, pe: int, shown: int) -> float:
    at = pe * array.ii + (shown - 1) % array.ii
    taken = min(1, places.counts[at]) + min(1, places.counts[array.pes * array.ii + at])
    return float(_CELL + _TAKEN * taken)


@inlined
def is_popular(edges: Edges, word: int) -> bool:
    """Whether a word has so many reads that no moves are claimed for it."""
    return bool(edges.sink_begin[word + 1] - edges.sink_begin[word] > _MOST_READS)


@inlined
def show(task: Task, places: Places, words: Words, word: int) -> None:
    """Claim moves for all reads of a word that is shown nowhere yet, in order of time."""
    edges, array = task.edges, task.array
    words.size[word] = 1
    words.pe[word, 0] = places.pe[word]
    words.cycle[word, 0] = 0
    ready = places.time[word] + task.nodes.latency[word]
    if is_popular(edges, word):
        return
    for at in range(_order_reads(edges, places, words.reads, word, ready)):
        gap, target = words.reads[at, 0], words.reads[at, 1]
        _serve(array, places, words, Read(word, ready, target, gap))


@inlined
def _order_reads(edges: Edges, places: Places, reads: Ints2, word: int, ready: int) -> int:
    """Sort the reads of a word by time into `reads`; returns how many there are."""
    begin, end = edges.sink_begin[word], edges.sink_begin[word + 1]
    for at in range(end - begin):
        edge = edges.sink_items[begin + at]
        reader = edges.dst[edge]
        gap = places.time[reader] + edges.ahead[edge] - ready
        to = at
        while to > 0 and reads[to - 1, 0] > gap:
            reads[to, 0], reads[to, 1] = reads[to - 1, 0], reads[to - 1, 1]
            to -= 1
        reads[to, 0], reads[to, 1] = gap, places.pe[reader]
    return int(end - begin)


@inlined
def _serve(array: Array, places: Places, words: Words, read: Read) -> None:
    """Claim the cheapest way to a read; none if it is too early for any, or too far off."""
    word, _, target, gap = read
    best, best_length, best_price = -1, 0, 1e30
    size = words.size[word]
    first = _nearest(array, words, read) if size > _MANY_CELLS else 0
    for turn in range(size):
        at = first if turn == 0 else turn - (turn <= first)
        origin, since = words.pe[word, at], words.cycle[word, at]
        hops = array.hop[origin, target]
        spare = gap - since - max(hops - 1, 0)
        if spare < 0 or hops > MOST_HOPS:
            continue
        if hops == 1 and spare == 0:
            return
        if hops == 0:
            best, best_length = 0, 0
            break
        if best_price <= _CELL * (hops - (spare == 0)):
            continue
        for late in range(1 if spare == 0 or spare >= array.ii else 2):
            row = 1 - best if best >= 0 else 0
            length, price = _way(array, places, words, read, row, at, late)
            if price < best_price:
                best, best_length, best_price = row, length, price
    if best < 0 or words.size[word] + best_length > words.pe.shape[1]:
        return
    for at in range(best_length):
        _add(array, places, words, read, words.path[best, at, 0], words.path[best, at, 1])
    _renew(array, places, words, read)


@inlined
def _nearest(array: Array, words: Words, read: Read) -> int:
    """The cell from which a read can be served that has the fewest links to it: the first, if there
    is none.
    """
    nearest, fewest = 0, 1 << 20
    for at in range(words.size[read.word]):
        hops = array.hop[words.pe[read.word, at], read.target]
        if hops < fewest and read.gap - words.cycle[read.word, at] >= max(hops - 1, 0):
            nearest, fewest = at, hops
    return nearest


@inlined
def _add(array: Array, places: Places, words: Words, read: Read, pe: int, cycle: int) -> None:
    to = words.size[read.word]
    words.pe[read.word, to], words.cycle[read.word, to] = pe, cycle
    words.size[read.word] = to + 1
    _claim(array, places, pe, read.ready + cycle, 1)


@inlined
def _renew(array: Array, places: Places, words: Words, read: Read) -> None:
    """A word that waits for II cycles where it is read goes to another register by a move."""
    word, ready, target, gap = read
    since = -1
    for at in range(words.size[word]):
        if words.pe[word, at] == target and words.cycle[word, at] <= gap:
            since = max(since, words.cycle[word, at])
    while 0 <= since <= gap - array.ii and words.size[word] < words.pe.shape[1]:
        best, best_price = since + array.ii, 1e30
        for cycle in range(since + array.ii, since, -1):
            price = _price(array, places, target, ready + cycle)
            if price < best_price:
                best, best_price = cycle, price
        since = best
        _add(array, places, words, read, target, since)


@inlined
def _way(
    array: Array, places: Places, words: Words, read: Read, row: int, cell: int, late: int
) -> tuple[int, float]:
    """A way from a cell as moves in `path[row]`: at once and then to wait where the read is, or
    `late`: to wait at its origin. Returns its length and price.
    """
    word, ready, target, gap = read
    origin, since = words.pe[word, cell], words.cycle[word, cell]
    hops = array.hop[origin, target]
    length, price, at = 0, 0.0, origin
    waits = gap - since - (hops - 1)
    shown = since
    if late:
        shown = since + waits
        words.path[row, 0, 0], words.path[row, 0, 1] = origin, shown
        price += _price(array, places, origin, ready + shown)
        length = 1
    steps = hops - 1 if late or waits == 0 else hops
    for _ in range(steps):
        shown += 1
        next_pe, next_price = -1, 1e30
        for near in range(array.near_begin[at], array.near_begin[at + 1]):
            pe = array.near_items[near]
            if array.hop[pe, target] == array.hop[at, target] - 1:
                its_price = _price(array, places, pe, ready + shown)
                if its_price < next_price:
                    next_pe, next_price = pe, its_price
        at = next_pe
        words.path[row, length, 0], words.path[row, length, 1] = at, shown
        length += 1
        price += next_price
    return length, price
