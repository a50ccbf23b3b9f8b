"""Which node is placed next, and a pass over all of them: compiled functions."""

from __future__ import annotations

from typing import NamedTuple

from vividc.mapper.engines.greedy.board import FULL, PARKED
from vividc.mapper.engines.greedy.compiled import compiled, inlined
from vividc.mapper.engines.greedy.placing import Pass, meeting, place
from vividc.mapper.resources.arrays import Floats, Ints

READY, PLACED = 0, 1
"""Positions in `Turn.counts`."""
GOING, DONE, LONG, NO_ROOM, STUCK = -1, -2, -3, -4, 0
"""How a pass stands: there are nodes to be placed; there are none; it takes too many cycles; the
board is too small; from `STUCK` on, the number of a node without a place.
"""


class Turn(NamedTuple):
    """Nodes that are `ready` to be placed, for how many others each still `waits`, when it was
    placed (`rank`), `counts`, and `late`: cycles in which accesses wait.
    """

    ready: Ints
    waits: Ints
    rank: Ints
    counts: Ints
    late: Floats


@compiled
def place_some(job: Pass, turn: Turn, tries: int, below: float, most: int) -> int:
    """Place nodes until so many placements were tried, or the region is sure to take as many cycles
    as `below`, those in which accesses wait among them; how the pass stands then.

    `most`: cycles at most by which a node makes the region longer, its word's way included.
    """
    task, board = job.task, job.board
    last = job.tried[0] + tries
    while job.tried[0] < last:
        if turn.counts[READY] == 0:
            return DONE
        if job.horizon[0] + most >= board.cycles:
            return NO_ROOM
        node = _take_first(job, turn)
        found = place(job, node)
        if board.counts[FULL]:
            return NO_ROOM
        if not found:
            return STUCK + node
        pe, time = board.cells[board.begin.pe + node], board.cells[board.begin.start + node]
        turn.late[0] += meeting(task, board, node, time)
        turn.counts[PLACED] += 1
        turn.rank[node] = turn.counts[PLACED]
        job.horizon[0] = max(job.horizon[0], time + task.nodes.ends[node])
        if time + task.nodes.after[node, pe] + turn.late[0] >= below:
            return LONG
        _release(job, turn, node)
    return GOING


@inlined
def _release(job: Pass, turn: Turn, node: int) -> None:
    """What waited for the node alone is ready."""
    nodes = job.task.nodes
    for at in range(nodes.next_begin[node], nodes.next_begin[node + 1]):
        follower = nodes.next_items[at]
        turn.waits[follower] -= 1
        if turn.waits[follower] == 0:
            turn.ready[turn.counts[READY]] = follower
            turn.counts[READY] += 1


class Rank(NamedTuple):
    """When a node comes: the less, the sooner."""

    added: int
    older: int
    lowest: int
    node: int


@inlined
def _take_first(job: Pass, turn: Turn) -> int:
    """The one to place next: the highest; while many words are parked, one that frees some."""
    board = job.board
    crowded = board.cells[board.begin.numbers + PARKED] > job.rules.parked
    first, best = 0, _rank(job, turn, turn.ready[0], crowded)
    for at in range(1, turn.counts[READY]):
        rank = _rank(job, turn, turn.ready[at], crowded)
        if _comes_before(rank, best):
            first, best = at, rank
    turn.counts[READY] -= 1
    turn.ready[first] = turn.ready[turn.counts[READY]]
    return best.node


@inlined
def _rank(job: Pass, turn: Turn, node: int, crowded: bool) -> Rank:
    added, older = 0, 0
    if crowded:
        added = _words_added(job, node)
        older = -_newest(job, turn, node) if job.rules.deep else 0
    return Rank(added, older, job.rules.lowest[node], node)


@inlined
def _comes_before(one: Rank, other: Rank) -> bool:
    if one.added != other.added:
        return one.added < other.added
    if one.older != other.older:
        return one.older < other.older
    return one.lowest < other.lowest if one.lowest != other.lowest else one.node < other.node


@inlined
def _words_added(job: Pass, node: int) -> int:
    """Words parked once the node is placed, less those whose last readers it is."""
    nodes, board = job.task.nodes, job.board
    unread = board.begin.unread
    added = 1 if board.cells[unread + node] else 0
    for at in range(nodes.source_begin[node], nodes.source_begin[node + 1]):
        if board.cells[unread + nodes.source_items[at]] == nodes.times[at]:
            added -= 1
    return added


@inlined
def _newest(job: Pass, turn: Turn, node: int) -> int:
    """When the newest of the words that it reads was made."""
    nodes, newest = job.task.nodes, 0
    for at in range(nodes.source_begin[node], nodes.source_begin[node + 1]):
        newest = max(newest, turn.rank[nodes.source_items[at]])
    return int(newest)
