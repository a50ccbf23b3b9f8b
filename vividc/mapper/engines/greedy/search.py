"""Searches for ways: A* (Hart, Nilsson and Raphael 1968), backwards in time from a reader to the
tree of a word: compiled functions.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from vividc.mapper.engines.greedy.board import NONE, Board, put, spot_of
from vividc.mapper.engines.greedy.compiled import inlined
from vividc.mapper.engines.greedy.task import Grid, Task
from vividc.mapper.engines.greedy.words import (
    RES,
    can_write,
    holder,
    keep_route,
    materialise,
    occupy,
    read,
    word_at,
)
from vividc.mapper.resources.arrays import Ints, Ints2

LINK_COST: Final = 4
"""Of a cycle in which a word takes a link that it does not take already."""
_WRITE_COST: Final = 2
_HOLD_COST: Final = 1
_MAX_EXPANSIONS: Final = 3000

TURN, WAITING, COST = 0, 1, 2
"""Positions in `Search.counts`: the number of the search, spots on the heap, what the way found
costs.
"""


class Search(NamedTuple):
    """Work space. By spot: the `turn` in which it was reached, at which `cost`, and the spot that
    it leads `to`. `heap` (spots waiting, 2): the estimate of the whole way and then the spot, as
    one number, and the cost so far. `hops`: by PE, links at least from where the word is. `found`:
    places that `_readable` lists.
    """

    turn: Ints
    cost: Ints
    to: Ints
    heap: Ints2
    hops: Ints
    found: Ints
    counts: Ints


class Word(NamedTuple):
    """A result on the array: its producer's PE and the first cycle in which it can be used."""

    node: int
    pe: int
    ready: int


def new_search(grid: Grid, cycles: int) -> Search:
    """For schedules of so many cycles."""
    spots = (cycles + 1) * grid.places
    ways = int((np.diff(grid.into_begin) + np.diff(grid.first)).max(initial=0)) + 1
    return Search(
        np.zeros(spots, dtype=np.int64),
        np.zeros(spots, dtype=np.int64),
        np.zeros(spots, dtype=np.int64),
        np.zeros(((_MAX_EXPANSIONS + 1) * ways, 2), dtype=np.int64),
        np.zeros(grid.pes, dtype=np.int64),
        np.zeros(ways, dtype=np.int64),
        np.zeros(3, dtype=np.int64),
    )


@inlined
def word_of(task: Task, board: Board, node: int) -> Word:
    """The word of a node that is placed."""
    begin = board.begin
    ready = board.cells[begin.start + node] + task.nodes.latency[node]
    return Word(node, board.cells[begin.pe + node], ready)


@inlined
def hops_from(grid: Grid, board: Board, word: Word, pe: int) -> int:
    """Links at least from where the word can be read at some time."""
    least = grid.distance[word.pe, pe]
    first = board.begin.over + word.node * board.pes
    for at in range(first, first + board.cells[board.begin.spread + word.node]):
        least = min(least, grid.distance[board.cells[at], pe])
    return int(least)


@inlined
def route(task: Task, board: Board, search: Search, edge: int, pe: int, time: int) -> int:
    """Take the cheapest way for a word to be readable on `pe` in cycle `time`; its cost, or `NONE`
    if there is no way.
    """
    word = word_of(task, board, task.edges.src[edge])
    if time == word.ready and pe == word.pe:
        put(board, board.begin.length + edge, 0)
        return 0
    first = _find(task.grid, board, search, word, pe, time)
    if first == NONE:
        return NONE
    last = _enter(task.grid, board, search, word.node, first)
    materialise(task.grid, board, word.node, last, time)
    read(task.grid, board, word.node, last, time)
    keep_route(board, edge, last, time)
    return int(search.counts[COST])


@inlined
def _enter(grid: Grid, board: Board, search: Search, node: int, first: int) -> int:
    """Occupy the spots that were found, from the first on; the place of the last."""
    driver, spot = RES, first
    while spot != NONE:
        place, time = spot % board.places, spot // board.places
        if holder(board, place, time) != node:
            materialise(grid, board, node, driver, time - 1)
            occupy(grid, board, node, place, time, driver)
        driver, spot = place, search.to[spot]
    return int(driver)


# --- searching ---


@inlined
def _find(grid: Grid, board: Board, search: Search, word: Word, pe: int, time: int) -> int:
    """The first spot of the cheapest way, or `NONE`: it is in the word's tree, or driven by its
    producer.
    """
    search.counts[TURN] += 1
    search.counts[WAITING] = 0
    for one in range(grid.pes):
        search.hops[one] = hops_from(grid, board, word, one)
    for at in range(_readable(grid, board, search.found, word.node, pe, time)):
        _reach(grid, board, search, word, search.found[at], time, NONE, 0)
    spots = board.places * board.cycles
    for _ in range(_MAX_EXPANSIONS):
        if search.counts[WAITING] == 0:
            return NONE
        spot, cost = search.heap[0, 0] % spots, search.heap[0, 1]
        _pop(search)
        if cost > search.cost[spot]:
            continue
        place, now = spot % board.places, spot // board.places
        if holder(board, place, now) == word.node or _starts(grid, board, word, place, now):
            search.counts[COST] = cost
            return int(spot)
        if now != word.ready:
            _reach_drivers(grid, board, search, word, spot, cost)
    return NONE


@inlined
def _starts(grid: Grid, board: Board, word: Word, place: int, time: int) -> bool:
    """Whether the producer can drive the spot."""
    if time != word.ready or grid.origin[place] != word.pe:
        return False
    return place < grid.links or can_write(grid, board, place, time - 1)


@inlined
def _reach_drivers(
    grid: Grid, board: Board, search: Search, word: Word, spot: int, cost: int
) -> None:
    """Add the places from which the word could have come to the free spot."""
    place, before = spot % board.places, spot // board.places - 1
    pe, node = grid.origin[place], word.node
    if place < grid.links:
        for at in range(_readable(grid, board, search.found, node, pe, before)):
            if search.found[at] != place:
                _reach(grid, board, search, word, search.found[at], before, spot, cost)
        return
    there = holder(board, place, before)
    if not NONE != there != node:
        _reach(grid, board, search, word, place, before, spot, cost)
    if can_write(grid, board, place, before):  # from the FU or a link: registers are not copied
        for at in range(_links(grid, board, search.found, node, pe, before)):
            link = search.found[at]
            _reach(grid, board, search, word, link, before, spot, cost + _WRITE_COST)


@inlined
def _reach(
    grid: Grid,
    board: Board,
    search: Search,
    word: Word,
    place: int,
    time: int,
    to: int,
    cost: int,
) -> None:
    """Add the spot to those waiting if the word can be there, unless known at this cost."""
    spot, pe = spot_of(board, place, time), grid.origin[place]
    joins = holder(board, place, time) == word.node
    if not joins:
        if time < word.ready + grid.distance[word.pe, pe]:
            return
        cost += LINK_COST if place < grid.links else _HOLD_COST
    if search.turn[spot] == search.counts[TURN] and search.cost[spot] <= cost:
        return
    search.turn[spot] = search.counts[TURN]
    search.cost[spot] = cost
    search.to[spot] = to
    estimate = 0 if joins else LINK_COST * search.hops[pe]
    _push(search, (cost + estimate) * board.places * board.cycles + spot, cost)


@inlined
def _links(grid: Grid, board: Board, found: Ints, node: int, pe: int, time: int) -> int:
    """List the links into `pe` that hold the result of `node` in cycle `time`, or nothing; returns
    how many there are.
    """
    count = 0
    for at in range(grid.into_begin[pe], grid.into_begin[pe + 1]):
        link = grid.into_items[at]
        there = word_at(board, link, time)
        if NONE != there != node:
            continue
        found[count] = link
        count += 1
    return count


@inlined
def _readable(grid: Grid, board: Board, found: Ints, node: int, pe: int, time: int) -> int:
    """List the links into `pe`, and registers of it, from which the word could be read in cycle
    `time`; returns how many there are. Of free registers one is enough.
    """
    count = _links(grid, board, found, node, pe, time)
    begin = board.begin
    is_full = board.cells[begin.reading + time * board.pes + pe] >= grid.read_ports[pe]
    fresh, has_older = NONE, False  # whether the cycle before is taken of the fresh one
    for register in range(grid.first[pe], grid.first[pe + 1]):
        if is_full and not board.cells[begin.read + spot_of(board, register, time)]:
            continue
        there = holder(board, register, time)
        if there == node:
            found[count] = register
            count += 1
        elif there == NONE and (fresh == NONE or has_older):
            is_older = word_at(board, register, time - 1) != NONE
            if fresh == NONE or not is_older:
                fresh, has_older = register, is_older
    if fresh != NONE:
        found[count] = fresh
        count += 1
    return count


# --- the heap ---


@inlined
def _push(search: Search, key: int, cost: int) -> None:
    heap, at = search.heap, search.counts[WAITING]
    search.counts[WAITING] = at + 1
    while at > 0 and heap[(at - 1) // 2, 0] > key:
        up = (at - 1) // 2
        heap[at, 0], heap[at, 1] = heap[up, 0], heap[up, 1]
        at = up
    heap[at, 0], heap[at, 1] = key, cost


@inlined
def _pop(search: Search) -> None:
    """Take the least from the heap."""
    heap, count = search.heap, search.counts[WAITING] - 1
    search.counts[WAITING] = count
    key, cost = heap[count, 0], heap[count, 1]
    at, low = 0, 1
    while low < count:
        if low + 1 < count and heap[low + 1, 0] < heap[low, 0]:
            low += 1
        if heap[low, 0] >= key:
            break
        heap[at, 0], heap[at, 1] = heap[low, 0], heap[low, 1]
        at = low
        low = 2 * at + 1
    heap[at, 0], heap[at, 1] = key, cost
