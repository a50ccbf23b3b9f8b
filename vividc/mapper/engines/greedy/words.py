"""Words on the board: where they are, how they come there, and where they wait: compiled functions.

The routes of one word form a tree (multicast). Every result that still has readers is *parked*: it
keeps a register from some cycle on, without end, until its last reader has been routed. So a word
can always be fetched later, when links are free again, and greedy scheduling cannot lose it.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from vividc.mapper.engines.greedy.board import (
    FULL,
    NONE,
    PARKED,
    STEPS,
    Board,
    add_to_chain,
    put,
    spot_of,
)
from vividc.mapper.engines.greedy.compiled import inlined
from vividc.mapper.engines.greedy.task import Grid, Task
from vividc.mapper.resources.arrays import Ints2

RES: Final = -1
"""Stands for the FU's result where the place of a word's driver is named."""


class Ways(NamedTuple):
    """Work space of parking: `by` (cycles, PEs): the link by which a PE is reached, or `NONE`."""

    by: Ints2


def cycles_to_park(grid: Grid) -> int:
    """After a word's result, within which it is in its register, or in none."""
    return 2 * grid.diameter + 3


# --- who is where ---


@inlined
def word_at(board: Board, place: int, time: int) -> int:
    """The node whose word is at the spot, or `NONE`."""
    return int(board.cells[board.begin.word + spot_of(board, place, time)])


@inlined
def holder(board: Board, place: int, time: int) -> int:
    """The node whose word is at the spot, or for whose word it is kept, or `NONE`."""
    node = word_at(board, place, time)
    if node != NONE:
        return node
    parked = board.cells[board.begin.parked + place]
    if parked != NONE and time >= board.cells[board.begin.since + place]:
        return int(parked)
    return NONE


@inlined
def can_write(grid: Grid, board: Board, register: int, time: int) -> bool:
    """Whether a write port is left for `register` to be written at the end of cycle `time`."""
    pe = grid.end[register]
    return bool(board.cells[board.begin.writing + time * board.pes + pe] < grid.write_ports[pe])


@inlined
def is_spread(board: Board, node: int, pe: int) -> bool:
    """Whether the word is on the PE, beside its producer's."""
    first = board.begin.over + node * board.pes
    for at in range(first, first + board.cells[board.begin.spread + node]):
        if board.cells[at] == pe:
            return True
    return False


# --- entering and leaving ---


@inlined
def occupy(grid: Grid, board: Board, node: int, place: int, time: int, driver: int) -> None:
    """The word comes to a free spot from the driver's place."""
    begin, spot, pe = board.begin, spot_of(board, place, time), grid.end[place]
    put(board, begin.word + spot, node)
    put(board, begin.driver + spot, driver)
    add_to_chain(board, begin.cells + node, spot)
    if not is_spread(board, node, pe):
        count = board.cells[begin.spread + node]
        put(board, begin.over + node * board.pes + count, pe)
        put(board, begin.spread + node, count + 1)
    if driver >= grid.links and driver != place:
        read(grid, board, node, driver, time - 1)
    if place < grid.links:
        return
    put(board, begin.last + place, max(time, board.cells[begin.last + place]))
    written = begin.written + spot - board.places
    if driver != place and not board.cells[written]:
        put(board, written, 1)
        _count(board, begin.writing, pe, time - 1, 1)


@inlined
def _count(board: Board, table: int, pe: int, time: int, by: int) -> None:
    at = table + time * board.pes + pe
    put(board, at, board.cells[at] + by)


@inlined
def read(grid: Grid, board: Board, node: int, place: int, time: int) -> None:
    """The word is read there: of a register, through a port, once a cycle."""
    if place < grid.links:
        return
    spot = spot_of(board, place, time)
    if not board.cells[board.begin.read + spot]:
        put(board, board.begin.read + spot, 1)
        _count(board, board.begin.reading, grid.end[place], time, 1)
        add_to_chain(board, board.begin.reads + node, spot)


@inlined
def materialise(grid: Grid, board: Board, node: int, place: int, time: int) -> None:
    """Turn what a parked word has kept up to `time` into occupied spots."""
    if place == RES or board.cells[board.begin.parked + place] != node:
        return
    first = time
    since = board.cells[board.begin.since + place]
    while first > since and word_at(board, place, first) == NONE:
        first -= 1
    for cycle in range(first + 1, time + 1):
        occupy(grid, board, node, place, cycle, place)


@inlined
def keep_route(board: Board, edge: int, place: int, time: int) -> None:
    """Put the route that leads from the producer to an occupied spot on record."""
    begin, length, at, cycle = board.begin, 0, place, time
    while at != RES:
        at = board.cells[begin.driver + spot_of(board, at, cycle)]
        cycle -= 1
        length += 1
    first = board.cells[begin.numbers + STEPS]
    if first + length > len(board.steps):
        board.counts[FULL] = 1
        length = 0
    put(board, begin.route + edge, first)
    put(board, begin.length + edge, length)
    put(board, begin.numbers + STEPS, first + length)
    for step in range(first + length - 1, first - 1, -1):
        spot = spot_of(board, place, time)
        board.steps[step] = spot
        place = board.cells[begin.driver + spot]
        time -= 1


@inlined
def settle(task: Task, board: Board, node: int) -> None:
    """All readers of `node` are routed: give back what it occupies beyond its routes."""
    grid, begin = task.grid, board.begin
    home = board.cells[begin.home + node]
    if home != NONE:
        put(board, begin.parked + home, NONE)
        put(board, begin.home + node, NONE)
        put(board, begin.numbers + PARKED, board.cells[begin.numbers + PARKED] - 1)
    at = board.cells[begin.cells + node]
    while at != NONE:
        _vacate(grid, board, board.chain[at, 0])
        at = board.chain[at, 1]
    at = board.cells[begin.reads + node]
    while at != NONE:
        spot = board.chain[at, 0]
        put(board, begin.read + spot, 0)
        place = spot % board.places
        _count(board, begin.reading, grid.end[place], spot // board.places, -1)
        at = board.chain[at, 1]
    put(board, begin.cells + node, NONE)
    put(board, begin.reads + node, NONE)
    put(board, begin.spread + node, 0)
    for number in range(task.nodes.fed_begin[node], task.nodes.fed_begin[node + 1]):
        _take_route(grid, board, node, task.nodes.fed_items[number])


@inlined
def _take_route(grid: Grid, board: Board, node: int, edge: int) -> None:
    first, driver = board.cells[board.begin.route + edge], RES
    length = board.cells[board.begin.length + edge]
    for at in range(first, first + length):
        spot = board.steps[at]
        place = spot % board.places
        time = spot // board.places
        if word_at(board, place, time) == NONE:
            occupy(grid, board, node, place, time, driver)
        driver = place
        if at == first + length - 1:
            read(grid, board, node, place, time)


@inlined
def _vacate(grid: Grid, board: Board, spot: int) -> None:
    begin, place, time = board.begin, spot % board.places, spot // board.places
    driver = board.cells[begin.driver + spot]
    put(board, begin.word + spot, NONE)
    if place < grid.links:
        return
    if driver != place:
        put(board, begin.written + spot - board.places, 0)
        _count(board, begin.writing, grid.end[place], time - 1, -1)
    if board.cells[begin.last + place] == time:
        while time >= 0 and word_at(board, place, time) == NONE:
            time -= 1
        put(board, begin.last + place, time)


# --- parking ---


@inlined
def park(grid: Grid, board: Board, ways: Ways, node: int, ready: int) -> bool:
    """Give the word a register without end, near its producer; False if none is left."""
    for pe in range(grid.pes):
        ways.by[0, pe] = NONE
    ways.by[0, board.cells[board.begin.pe + node]] = 0
    for turn in range(len(ways.by) - 1):
        for pe in range(grid.pes):
            if ways.by[turn, pe] != NONE:
                register = _endless(grid, board, pe, ready + turn)
                if register != NONE:
                    _park(grid, board, ways, node, ready, turn, register)
                    return True
        _go_on(grid, board, ways, turn, ready + turn)
    return False


@inlined
def _go_on(grid: Grid, board: Board, ways: Ways, turn: int, time: int) -> None:
    """By which links, free in that cycle, which PEs are reached."""
    for pe in range(grid.pes):
        ways.by[turn + 1, pe] = NONE
    for pe in range(grid.pes):
        if ways.by[turn, pe] == NONE:
            continue
        for at in range(grid.out_begin[pe], grid.out_begin[pe + 1]):
            link = grid.out_items[at]
            there = grid.end[link]
            if ways.by[turn + 1, there] == NONE and word_at(board, link, time) == NONE:
                ways.by[turn + 1, there] = link


@inlined
def _endless(grid: Grid, board: Board, pe: int, since: int) -> int:
    """A register of `pe` that nobody needs from `since` on and that can be written then."""
    begin, best = board.begin, NONE
    for register in range(grid.first[pe], grid.first[pe + 1]):
        last = board.cells[begin.last + register]
        if board.cells[begin.parked + register] != NONE or last >= since:
            continue
        if best == NONE or last > board.cells[begin.last + best]:
            best = register
    if best == NONE or not can_write(grid, board, best, since - 1):
        return NONE
    return best


@inlined
def _park(
    grid: Grid, board: Board, ways: Ways, node: int, ready: int, turns: int, register: int
) -> None:
    begin, place, pe = board.begin, register, grid.end[register]
    for turn in range(turns, -1, -1):
        driver = ways.by[turn, pe] if turn else RES
        occupy(grid, board, node, place, ready + turn, driver)
        place = driver
        if turn:
            pe = grid.origin[driver]
    put(board, begin.parked + register, node)
    put(board, begin.since + register, ready + turns)
    put(board, begin.home + node, register)
    put(board, begin.numbers + PARKED, board.cells[begin.numbers + PARKED] + 1)
