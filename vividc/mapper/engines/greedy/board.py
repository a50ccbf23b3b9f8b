"""What a pass has decided so far, and how a trial placement is taken back: compiled functions.

There is no wrap-around: every (place, cycle) is a *spot* of its own, and what is claimed of a cycle
is in a row of its own. All that a trial changes is in one array, so that a journal of places in it
and what they held is enough to take any of it back.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from vividc.mapper.engines.greedy.compiled import inlined
from vividc.mapper.engines.greedy.task import Grid, Task
from vividc.mapper.problem import Fill, Taken
from vividc.mapper.resources.arrays import Ints, Ints2, ints

NONE: Final = -1
CHANGES, FULL = 0, 1
"""Positions in `Board.counts`: entries of the journal; 1 once something had no room."""
CELLS, STEPS, PARKED = 0, 1, 2
"""Numbers behind `Begin.numbers`: cells of chains, steps of routes, words that are parked."""


class Begin(NamedTuple):
    """Where each table begins in `Board.cells`. Those up to `read` hold `NONE` at first, others 0.

    By spot (a row of places for each cycle): the node whose `word` is there, its `driver`, whether
    it is `read` and `written`. By cycle and PE: ports that are `reading` and `writing`, whether an
    operation is `issued`, `completed`, or a live-out `shown`. By cycle: `control` results,
    `accesses`, the `latest` of those that may meet others. By place: the node `parked` there,
    `since` when, and the `last` cycle in which it holds a word. By node: its `pe` and `start`, the
    access issued `earlier` in its cycle, the register that is its word's `home`, chains of its
    `cells` and `reads`, by how many edges it is `unread`, on how many PEs its word is (`spread`),
    and `over` which. By edge: the first step of its `route`, and its `length`. By PE: entries
    `stored`, and `held`, by key.
    """

    word: int
    driver: int
    latest: int
    parked: int
    last: int
    pe: int
    earlier: int
    home: int
    cells: int
    reads: int
    read: int
    written: int
    reading: int
    writing: int
    issued: int
    completed: int
    shown: int
    control: int
    accesses: int
    since: int
    start: int
    unread: int
    spread: int
    over: int
    route: int
    length: int
    stored: int
    held: int
    numbers: int


class Board(NamedTuple):
    """`cells`: all that a trial changes, as `Begin` says; `journal`: (place there, what it held);
    `chain`: (spot, next) of lists of spots; `steps`: spots of routes; `counts`: see `CHANGES`.
    """

    begin: Begin
    pes: int
    places: int
    keys: int
    cycles: int
    cells: Ints
    journal: Ints2
    chain: Ints2
    steps: Ints
    counts: Ints


_BY_SPOT: Final = ("word", "driver", "read", "written")
_BY_CYCLE_AND_PE: Final = ("reading", "writing", "issued", "completed", "shown")
_BY_CYCLE: Final = ("latest", "control", "accesses")
_BY_PLACE: Final = ("parked", "last", "since")
_BY_EDGE: Final = ("route", "length")


def new_board(task: Task, cycles: int, room: int, loops: Sequence[Taken] = ()) -> Board:
    """Nothing is placed, but for what loops take that end and begin; for schedules of so many
    cycles, and so many spots of words.
    """
    grid, nodes, keys = task.grid, len(task.nodes.kind), task.held.shape[1]
    a_cycle = dict.fromkeys(_BY_SPOT, grid.places) | dict.fromkeys(_BY_CYCLE_AND_PE, grid.pes)
    a_cycle |= dict.fromkeys(_BY_CYCLE, 1)
    sizes = {table: (cycles + 1) * row for table, row in a_cycle.items()}
    sizes |= dict.fromkeys(_BY_PLACE, grid.places) | dict.fromkeys(_BY_EDGE, len(task.edges.src))
    sizes |= {"over": nodes * grid.pes, "stored": grid.pes, "held": grid.pes * keys, "numbers": 3}
    ends = np.cumsum([sizes.get(table, nodes) for table in Begin._fields]).tolist()
    first = Begin(0, *ends[:-1])
    cells = np.zeros(ends[-1], dtype=np.int64)
    cells[: first.read] = NONE
    cells[first.unread : first.spread] = np.diff(task.nodes.fed_begin)
    cells[first.stored : first.held] = task.stored
    cells[first.held : first.numbers] = task.held.ravel()
    rows = {table: getattr(first, table) + row for table, row in a_cycle.items()}
    begin = first._replace(**rows)  # from cycle 0 on: in the row before is what is before the first
    for taken in loops:
        _take(cells, begin, grid, nodes, taken, cycles)
    return Board(
        begin,
        grid.pes,
        grid.places,
        keys,
        cycles,
        cells,
        np.zeros((room, 2), dtype=np.int64),
        np.zeros((room, 2), dtype=np.int64),
        np.zeros(room, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
    )


def _take(cells: Ints, begin: Begin, grid: Grid, node: int, taken: Taken, cycles: int) -> None:
    """What a loop takes is taken for ever, in the name of a node that there is not. A register
    that one which begins writes is no other's, and no port is shared with one that may begin later.
    """
    by_pe = (
        (begin.issued, taken.issued),
        (begin.completed, taken.completed),
        (begin.shown, taken.shown),
    )
    for table, some in by_pe:
        at = [cycle * grid.pes + pe for pe, cycle in some if cycle <= cycles]
        cells[ints(table + place for place in at)] = 1
    at = [cycle for cycle, *_ in taken.accesses if cycle <= cycles]
    cells[ints(begin.accesses + cycle for cycle in at)] = grid.banks  # else others would wait
    for kind, pe, index, cycle in taken.words:
        place = index if kind == "link" else grid.first[pe] + index
        if kind == "reg":
            until = cycles if isinstance(taken, Fill) else cycle
            cells[begin.last + place] = max(cells[begin.last + place], until)
        if cycle <= cycles:
            cells[begin.word + cycle * grid.places + place] = node
    ports = (
        (begin.writing, begin.written, taken.written),
        (begin.reading, begin.read, taken.read),
    )
    for by_file, by_register, some_words in ports:
        for pe, register, cycle in (one for one in some_words if one[-1] <= cycles):
            cells[by_file + cycle * grid.pes + pe] += 1
            if by_register != begin.read or not isinstance(taken, Fill):
                cells[by_register + cycle * grid.places + grid.first[pe] + register] = 1


# --- changes ---


@inlined
def put(board: Board, place: int, value: int) -> None:
    """Change a cell, on record."""
    at = board.counts[CHANGES]
    if at < len(board.journal):
        board.journal[at, 0], board.journal[at, 1] = place, board.cells[place]
        board.counts[CHANGES] = at + 1
    else:
        board.counts[FULL] = 1
    board.cells[place] = value


@inlined
def back_to(board: Board, mark: int) -> None:
    """Take back all changes but the first so many."""
    at = board.counts[CHANGES]
    while at > mark:
        at -= 1
        board.cells[board.journal[at, 0]] = board.journal[at, 1]
    board.counts[CHANGES] = mark


@inlined
def spot_of(board: Board, place: int, time: int) -> int:
    """The number of a spot."""
    return time * board.places + place


# --- chains ---


@inlined
def add_to_chain(board: Board, head: int, spot: int) -> None:
    """Put a spot before those of the chain that begins at a cell."""
    at = board.cells[board.begin.numbers + CELLS]
    if at >= len(board.chain):
        board.counts[FULL] = 1
        return
    board.chain[at, 0], board.chain[at, 1] = spot, board.cells[head]
    put(board, head, at)
    put(board, board.begin.numbers + CELLS, at + 1)
