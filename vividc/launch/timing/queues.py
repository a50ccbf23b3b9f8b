"""Queues in order of two keys, as binary heaps in arrays: compiled functions."""

from __future__ import annotations

from vividc.launch.flat import Ints2
from vividc.launch.timing.compiled import inlined
from vividc.launch.timing.state import Queues


@inlined
def push(queues: Queues, queue: int, row: tuple[int, int, int, int]) -> None:
    """Add (first key, second key, what, item) to a queue."""
    rows, begin = queues.rows, queues.begin[queue]
    first, second, what, item = row
    place = queues.length[queue]
    queues.length[queue] += 1
    queues.pushed[queue] += 1
    while place > 0:
        above = (place - 1) // 2
        if not _is_before(first, second, rows, begin + above):
            break
        _copy(rows, begin + above, begin + place)
        place = above
    place += begin
    rows[place, 0], rows[place, 1], rows[place, 2], rows[place, 3] = first, second, what, item


@inlined
def pop(queues: Queues, queue: int) -> tuple[int, int, int, int]:
    """Take the row of the smallest keys out; the queue is not empty."""
    rows, begin = queues.rows, queues.begin[queue]
    smallest = rows[begin, 0], rows[begin, 1], rows[begin, 2], rows[begin, 3]
    queues.length[queue] -= 1
    last = queues.length[queue]
    first, second = rows[begin + last, 0], rows[begin + last, 1]
    place, below = 0, 1
    while below < last:
        other = begin + below + 1
        if below + 1 < last and _is_before(rows[other, 0], rows[other, 1], rows, other - 1):
            below += 1
        if _is_before(first, second, rows, begin + below):
            break
        _copy(rows, begin + below, begin + place)
        place, below = below, 2 * below + 1
    _copy(rows, begin + last, begin + place)
    return smallest


@inlined
def _is_before(first: int, second: int, rows: Ints2, place: int) -> bool:
    """Whether keys are smaller than those of a row."""
    if first != rows[place, 0]:
        return bool(first < rows[place, 0])
    return bool(second < rows[place, 1])


@inlined
def _copy(rows: Ints2, source: int, target: int) -> None:
    for column in range(4):
        rows[target, column] = rows[source, column]
