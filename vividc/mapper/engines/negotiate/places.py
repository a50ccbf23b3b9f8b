"""Places and times of all nodes, and what they claim: compiled functions over `Places`."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from vividc.mapper.engines.negotiate.arrays import (
    CONTROL,
    FU,
    LEAVES,
    MEMORY,
    RESIDENT,
    WRITTEN,
    Array,
    Edges,
    Meets,
    Nodes,
    Task,
)
from vividc.mapper.engines.negotiate.compiled import compiled, inlined
from vividc.mapper.resources.arrays import Ints, Ints2

MET: Final = 32
"""Accesses whose bits are in one number."""


class Places(NamedTuple):
    """The state: `pe` and `time` of each node, and its `slot`, the time modulo II; `counts` of
    claims: issue, completion and live-out slots by PE, then banks and controller by slot; `over`:
    claims beyond capacity, one int64; `at`: a node that issues in a slot, or -1; `held` and
    `stored`: uses of constant-store entries by PE; `random`: one int64; `met`: by slot, bits
    of the accesses there that may meet others in a bank.
    """

    pe: Ints
    time: Ints
    slot: Ints
    counts: Ints
    over: Ints
    at: Ints
    held: Ints2
    stored: Ints
    random: Ints
    met: Ints2


def new_places(task: Task, seed: int) -> Places:
    """Nothing is placed yet: PE -1."""
    count, array = len(task.nodes.latency), task.array
    grid = array.pes * array.ii
    return Places(
        np.full(count, -1, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros(3 * grid + 2 * array.ii, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.full(grid, -1, dtype=np.int64),
        array.held.copy(),
        array.stored.copy(),
        np.array([seed * 2_654_435_769 + 1], dtype=np.int64),
        _all_in_first_slot(task),
    )


def _all_in_first_slot(task: Task) -> Ints2:
    accesses = len(task.meets.node)
    met = np.zeros((task.array.ii, -(-accesses // MET)), dtype=np.int64)
    for access in range(accesses):
        met[0, access // MET] |= 1 << (access % MET)
    return met


@inlined
def draw(random: Ints, below: int) -> int:
    """The next number of a 64-bit linear congruential generator (Knuth), in 0 .. below - 1."""
    random[0] = random[0] * 6364136223846793005 + 1442695040888963407
    return int((((random[0] >> 33) & 0x3FFFFFFF) * below) >> 30)


@inlined
def count(places: Places, at: int, by: int, room: int) -> None:
    """Add `by` to the claims of `counts[at]`, of which there is room for `room`."""
    old = places.counts[at]
    places.counts[at] = old + by
    places.over[0] += max(0, old + by - room) - max(0, old - room)


@inlined
def wrapped(slot: int, ii: int) -> int:
    """A slot of less than two IIs, in 0 .. `ii` - 1, without a division."""
    return slot - ii if slot >= ii else slot


@inlined
def lie(task: Task, places: Places, node: int, pe: int, time: int) -> None:
    """Have `node`, which claims nothing now, be on a PE at a time."""
    places.pe[node], places.time[node] = pe, time
    keep_slot(task.meets, places, node, task.array.slots[time])


@inlined
def keep_slot(meets: Meets, places: Places, node: int, slot: int) -> None:
    """Note the slot of a node's time."""
    access = meets.access[node]
    if access >= 0:
        bit = 1 << (access % MET)
        places.met[places.slot[node], access // MET] ^= bit
        places.met[slot, access // MET] ^= bit
    places.slot[node] = slot


@compiled
def lie_all(task: Task, places: Places, pes: Ints, times: Ints) -> None:
    """Have all nodes, which claim nothing now, be on these PEs at these times, and claim it."""
    for node in range(len(pes)):
        lie(task, places, node, pes[node], times[node])
        enter(task.nodes, task.array, places, node, 1)


@compiled
def enter(nodes: Nodes, array: Array, places: Places, node: int, by: int) -> None:
    """Add `by` (1 or -1) to all that `node` claims where it is."""
    ii, grid = array.ii, array.pes * array.ii
    pe = places.pe[node]
    row, slot = pe * ii, places.slot[node]
    kind = nodes.kind[node]
    if kind & FU:
        done = wrapped(slot + nodes.done[node], ii)
        at = slot
        for _ in range(nodes.busy[node]):
            count(places, row + at, by, 1)
            at = wrapped(at + 1, ii)
        count(places, grid + row + done, by, 1)
        if by > 0:
            places.at[row + slot] = node
        elif places.at[row + slot] == node:
            places.at[row + slot] = -1
        if kind & MEMORY:
            count(places, 3 * grid + slot, by, array.banks)
        if kind & CONTROL:
            count(places, 3 * grid + ii + done, by, 1)
    else:
        count(places, 2 * grid + row + slot, by, 1)
    stored = places.stored[pe]
    for at in range(nodes.key_begin[node], nodes.key_begin[node + 1]):
        key = nodes.key_items[at]
        old = places.held[pe, key]
        places.held[pe, key] = old + by * nodes.key_uses[at]
        if old == 0:
            places.stored[pe] += 1
        elif places.held[pe, key] == 0:
            places.stored[pe] -= 1
        places.over[0] += contested(places.held[pe, key]) - contested(old)
    room = array.room[pe]
    places.over[0] += max(0, places.stored[pe] - room) - max(0, stored - room)


@inlined
def excess(nodes: Nodes, array: Array, places: Places, node: int) -> int:
    """Claims beyond capacity in the slots and the store that `node`, entered, claims."""
    ii, grid = array.ii, array.pes * array.ii
    pe = places.pe[node]
    row, slot = pe * ii, places.slot[node]
    kind = nodes.kind[node]
    over = max(0, places.stored[pe] - array.room[pe])
    if array.rivals:
        over += _rivals(nodes, places, node)
    if kind & FU:
        done = wrapped(slot + nodes.done[node], ii)
        over += places.counts[grid + row + done] - 1
        at = slot
        for _ in range(nodes.busy[node]):
            over += places.counts[row + at] - 1
            at = wrapped(at + 1, ii)
        if kind & MEMORY:
            over += max(0, places.counts[3 * grid + slot] - array.banks)
        if kind & CONTROL:
            over += places.counts[3 * grid + ii + done] - 1
    else:
        over += places.counts[2 * grid + row + slot] - 1
    return int(over)


@inlined
def _rivals(nodes: Nodes, places: Places, node: int) -> int:
    """Contested entries of the node's on its PE."""
    both = 0
    for at in range(nodes.key_begin[node], nodes.key_begin[node + 1]):
        both += contested(places.held[places.pe[node], nodes.key_items[at]])
    return both


@inlined
def contested(uses: int) -> int:
    """1 if an entry is both read and written on its PE: iterations overlap, so a live-out would
    take from its readers the word they want.
    """
    here = uses % RESIDENT
    return int(here >= WRITTEN and here % WRITTEN > 0)


@compiled
def broken(task: Task, places: Places) -> int:
    """How much is wrong: claims beyond capacity and cycles that words or nodes come too early."""
    wrong = places.over[0]
    for edge in range(len(task.edges.src)):
        wrong += early(task.edges, task.array, places, edge)
    return int(wrong)


@compiled
def early(edges: Edges, array: Array, places: Places, edge: int) -> int:
    """Cycles by which the end of an edge comes too early for its beginning."""
    src, dst = edges.src[edge], edges.dst[edge]
    gap = places.time[dst] - places.time[src]
    if edges.routed[edge]:
        return int(max(0, edges.ready[edge] + array.reach[places.pe[src], places.pe[dst]] - gap))
    return int(max(0, edges.shift[edge] - gap))


@inlined
def window(task: Task, places: Places, node: int, result: Ints) -> None:
    """First and last time that keep all dependences as the other nodes lie, into `result`.

    Without a limit on one side, II times are enough: they are all the slots.
    """
    edges, array = task.edges, task.array
    first, last = 0, task.nodes.last[node]
    free_below, free_above = True, True
    for at in range(edges.of_begin[node], edges.of_begin[node + 1]):
        time, shift = places.time[edges.of_other[at]], edges.of_shift[at]
        if edges.of_kind[at] & LEAVES:
            last = min(last, time - shift)
            free_above = False
        else:
            first = max(first, time + shift)
            free_below = False
    if free_above and not free_below:
        last = min(last, first + array.ii + 1)
    if free_below and not free_above:
        first = max(first, last - array.ii - 1)
    result[0], result[1] = first, last
